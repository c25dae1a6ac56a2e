use super::*;
use crate::random::Purpose;

const ALL: [UncertainQuantity; 10] = UncertainQuantity::ALL;

fn table(rows: &[[f64; 2]]) -> Distribution {
    Distribution::Table(rows.into()).checked().unwrap()
}

/// By hand: a uniform number at Phi(z) = 1/4; half of a table's way; a normal number that is cut at its mean
/// has the median at 0.6745 deviations and the mean at sqrt(2/pi) of them.
#[test]
fn closed_form_numbers_at_coordinates() {
    let quarter = -0.674_489_750_196_081_7;
    assert!((Distribution::Uniform([-1.0, 3.0]).at(quarter) - 0.0).abs() < 1e-12);
    assert!((Distribution::Normal { mean: 1.0, sigma: 2.0 }.at(1.5) - 4.0).abs() < 1e-12);
    let half = Distribution::TruncatedNormal { mean: 1.0, sigma: 2.0, range: [1.0, 100.0] };
    assert!((half.at(0.0) - (1.0 - 2.0 * quarter)).abs() < 1e-9, "{}", half.at(0.0));
    let (mean, sigma) = half.mean_and_sigma();
    let two_over_pi = std::f64::consts::FRAC_2_PI;
    assert!((mean - 1.0 - 2.0 * two_over_pi.sqrt()).abs() < 1e-3, "{mean}");
    assert!((sigma - 2.0 * (1.0 - two_over_pi).sqrt()).abs() < 3e-3, "{sigma}");
    // Far out a mirror image keeps its digits.
    let far = Distribution::TruncatedNormal { mean: 0.0, sigma: 1.0, range: [7.0, 9.0] };
    assert!(far.at(0.0) > 7.05 && far.at(0.0) < 7.15, "{}", far.at(0.0));
    // 80 % uniform from 0 to 1, 20 % from 1 to 5.
    let tail = table(&[[0.0, 0.0], [0.8, 1.0], [1.0, 5.0]]);
    assert!((tail.at(0.0) - 0.625).abs() < 1e-12 && (tail.at(40.0) - 5.0).abs() < 1e-12);
    assert!((tail.mean_and_sigma().0 - (0.8 * 0.5 + 0.2 * 3.0)).abs() < 1e-12);
}

/// Draws by a stream and by coordinates have the mean and the deviation of their distribution, within four
/// standard errors of 20 000 (of the deviation's, six times that: tails are long).
#[test]
fn closed_form_draws_have_their_distribution() {
    let n = 20_000;
    for distribution in [
        Distribution::Uniform([-0.2, 0.4]),
        Distribution::Normal { mean: 0.1, sigma: 0.05 },
        Distribution::TruncatedNormal { mean: 0.0, sigma: 0.3, range: [-0.1, 0.5] },
        table(&[[0.0, -0.1], [0.5, 0.0], [1.0, 0.4]]),
    ] {
        let (mean, sigma) = distribution.mean_and_sigma();
        let mut stream = Stream::new(5, Purpose::Dice, 1);
        let mut found = [Vec::new(), Vec::new()];
        for _ in 0..n {
            found[0].push(distribution.draw(&mut stream));
            found[1].push(distribution.at(stream.normal()));
        }
        let [least, most] = distribution.support();
        for numbers in found {
            let of_all =
                |term: &dyn Fn(f64) -> f64| numbers.iter().map(|x| term(*x)).sum::<f64>() / f64::from(n);
            let error = sigma / f64::from(n).sqrt();
            let found_mean = of_all(&|x| x);
            let found_sigma = of_all(&|x| (x - found_mean).powi(2)).sqrt();
            assert!((found_mean - mean).abs() < 4.0 * error, "{distribution:?} {found_mean} {mean}");
            assert!((found_sigma - sigma).abs() < 6.0 * error, "{distribution:?} {found_sigma} {sigma}");
            assert!(numbers.iter().all(|x| (least..=most).contains(x)));
        }
    }
}

fn mass_and_inertia() -> JointNormal {
    let covariance = [vec![4e-4, 3e-4], vec![3e-4, 9e-4]];
    JointNormal::new(vec![UncertainQuantity::Inertia, UncertainQuantity::Mass], vec![0.0, 0.01], &covariance)
        .unwrap()
}

/// What is normal together has its covariance, in draws and by coordinates, within five standard errors of
/// 20 000; what is on its own has nothing to do with it.
#[test]
fn closed_form_draws_have_their_covariance() {
    let uncertain = Uncertainty::none()
        .with(UncertainQuantity::Thrust, Distribution::Normal { mean: 0.0, sigma: 0.02 })
        .with_together(mass_and_inertia());
    let n = 20_000;
    let mut stream = Stream::new(5, Purpose::Dice, 2);
    for by_coordinates in [false, true] {
        let mut sums = [0.0; 4];
        for _ in 0..n {
            let z: [f64; 10] = stream.normals::<10>().into();
            let off = if by_coordinates {
                uncertain.at(|quantity| z[quantity as usize])
            } else {
                uncertain.draw(&mut stream)
            };
            let [i, m, t] = [UncertainQuantity::Inertia, UncertainQuantity::Mass, UncertainQuantity::Thrust]
                .map(|quantity| off.of(quantity));
            let m = m - 0.01;
            [i * i, m * m, i * m, t * m].into_iter().zip(&mut sums).for_each(|(x, sum)| *sum += x);
        }
        let [ii, mm, im, tm] = sums.map(|sum| sum / f64::from(n));
        let error = 1.0 / f64::from(n).sqrt();
        assert!((ii / 4e-4 - 1.0).abs() < 5.0 * 1.42 * error && (mm / 9e-4 - 1.0).abs() < 5.0 * 1.42 * error);
        assert!((im - 3e-4).abs() < 5.0 * 7e-4 * error, "{im}");
        assert!(tm.abs() < 5.0 * 6e-4 * error, "{tm}");
    }
    assert_eq!(mass_and_inertia().correlation(ALL[0], ALL[1]), Some(0.5));
}

/// The last word on a quantity stands; the others of its covariance keep what they were.
#[test]
fn one_that_overrides_takes_a_quantity_out_of_its_covariance() {
    let together = Uncertainty::none().with_together(mass_and_inertia());
    let mass = Uncertainty::none().with(UncertainQuantity::Mass, Distribution::Uniform([-0.1, 0.1]));
    let both = together.overridden_by(&mass);
    assert_eq!(both.of(UncertainQuantity::Mass), Some(Distribution::Uniform([-0.1, 0.1])));
    assert_eq!(both.of(UncertainQuantity::Inertia), together.of(UncertainQuantity::Inertia));
    assert_eq!(both.quantities(), [UncertainQuantity::Mass, UncertainQuantity::Inertia]);
    assert_eq!(
        mass.overridden_by(&together).of(UncertainQuantity::Mass),
        together.of(UncertainQuantity::Mass)
    );
    assert!(Uncertainty::none().is_none() && !both.is_none());
    assert_eq!(together.ends().len(), 4);
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let refused = |distribution: Distribution| distribution.checked().unwrap_err();
    assert_eq!(refused(Distribution::Uniform([0.1, -0.1])), UnfitDistribution::Descending);
    assert_eq!(refused(Distribution::Normal { mean: 0.0, sigma: -1.0 }), UnfitDistribution::Sigma);
    assert_eq!(refused(Distribution::Normal { mean: f64::NAN, sigma: 1.0 }), UnfitDistribution::NotFinite);
    let far = Distribution::TruncatedNormal { mean: 0.0, sigma: 0.01, range: [1.0, 2.0] };
    assert_eq!(refused(far), UnfitDistribution::Outside);
    for rows in [vec![], vec![[0.0, 1.0]], vec![[0.0, 1.0], [0.9, 2.0]], vec![[0.0, 1.0], [1.0, 0.5]]] {
        assert_eq!(refused(Distribution::Table(rows.into())), UnfitDistribution::Table);
    }
    let joint = |quantities: &[UncertainQuantity], rows: &[Vec<f64>]| {
        JointNormal::new(quantities.to_vec(), vec![0.0; quantities.len()], rows).unwrap_err()
    };
    let two = [ALL[0], ALL[1]];
    assert_eq!(joint(&two[..1], &[vec![1.0]]), UnfitCovariance::Few);
    assert_eq!(joint(&[ALL[0], ALL[0]], &[vec![1.0, 0.0], vec![0.0, 1.0]]), UnfitCovariance::Twice);
    assert_eq!(joint(&two, &[vec![1.0, 0.0]]), UnfitCovariance::Size);
    assert_eq!(joint(&two, &[vec![1.0, 0.1], vec![0.2, 1.0]]), UnfitCovariance::Asymmetric);
    assert_eq!(joint(&two, &[vec![1.0, 2.0], vec![2.0, 1.0]]), UnfitCovariance::NotPositive);
}

#[test]
fn keys_lead_back_and_nothing_is_left_of_no_share() {
    for quantity in ALL {
        assert_eq!(UncertainQuantity::from_key(quantity.key()), Some(quantity));
    }
    let mut off = Deviations::default();
    off.set(UncertainQuantity::Mass, -3.0);
    off.set(UncertainQuantity::Latency, -0.1);
    assert!(off.variation().mass > 0.0 && off.variation().latency_s == 0.0);
}
