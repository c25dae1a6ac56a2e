//! Wider vector registers where the processor has them.
//!
//! The planner's small matrix products and the batch engine's lanes are plain loops; compiled for any x86-64
//! they fill registers of two numbers. [`vectorised`] compiles its argument a second time for AVX2, with
//! four, and picks by what the processor has. Fused multiply-add stays off: each number is then the outcome
//! of the same operations in the same order, and wide registers change no bit.
//!
//! [`lanes`] has the registers themselves as a number, for what the compiler does not find by itself. These
//! two files are the only place with `unsafe` code.

/// A computation that [`vectorised`] compiles twice. (A closure would not do: it cannot be forced to be
/// inlined.)
pub trait Kernel {
    /// The result of the computation.
    type Output;
    /// Computes the result. Implement this, and mark what it calls, as `#[inline(always)]`: only what is
    /// inlined into [`vectorised`] gains.
    fn run(self) -> Self::Output;
}

/// Runs `kernel`, compiled for AVX2 if the processor has it.
#[inline]
pub fn vectorised<W: Kernel>(kernel: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        fn with_avx2<W: Kernel>(kernel: W) -> W::Output {
            kernel.run()
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            #[expect(unsafe_code, reason = "a function compiled for AVX2 may only run where there is AVX2")]
            // SAFETY: the line above has just found AVX2.
            return unsafe { with_avx2(kernel) };
        }
    }
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[expect(unsafe_code, reason = "numbers of these types are made with a proof of AVX2, or of one another")]
pub mod lanes;

#[cfg(test)]
mod tests {
    use super::*;

    struct Products<'a>(&'a [f64]);

    impl Kernel for Products<'_> {
        type Output = [u64; 10];

        #[inline(always)]
        fn run(self) -> [u64; 10] {
            let mut sum = [0.0; 10];
            for (k, a) in self.0.iter().enumerate() {
                for (i, s) in sum.iter_mut().enumerate() {
                    *s += a * self.0[(i + k) % self.0.len()];
                }
            }
            sum.map(f64::to_bits)
        }
    }

    #[test]
    fn prop_both_paths_give_the_same_bits() {
        let x: Vec<f64> = (1..200).map(|i| 1.0 / f64::from(i) - 0.1).collect();
        assert_eq!(vectorised(Products(&x)), Products(&x).run());
    }
}
