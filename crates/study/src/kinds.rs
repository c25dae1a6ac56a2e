//! All kinds of studies, and campaigns. Who adds one adds its folder, its module in `lib.rs`, and its line
//! here.

use crate::designing::search::Designs;
use crate::effects::Effects;
use crate::envelope::Envelope;
use crate::free_fall::FreeFall;
use crate::kind::{About, Kind};
use crate::rare::Rare;
use crate::replan::Replan;
use crate::sobol::Sobol;
use crate::tuning::px4::TunePx4;
use crate::tuning::search::Tune;
use crate::{drops, own, paper};

/// The kinds, in the order in which they are offered.
pub const KINDS: [&dyn Kind; 9] =
    [&Effects, &Envelope, &Rare, &Sobol, &Replan, &FreeFall, &Designs, &Tune, &TunePx4];

/// Campaigns, which `samara assess` flies: their lines are files of their own, that grow.
pub const CAMPAIGNS: [&About; 3] = [&own::ABOUT, &paper::ABOUT, &drops::ABOUT];

/// All kinds with what they have: the rows of the table, whose columns are
/// [`Feature::ALL`](crate::feature::Feature::ALL).
pub fn table() -> Vec<About> {
    let campaigns = CAMPAIGNS.into_iter().copied();
    campaigns.chain(KINDS.iter().map(|kind| kind.about())).collect()
}

/// The kind of this name, as it is typed or as its files begin.
///
/// # Errors
/// What is expected in its place.
pub fn kind(name: &str) -> Result<&'static dyn Kind, String> {
    let named = |kind: &&&'static dyn Kind| kind.about().name == name.replace('-', "_");
    KINDS.iter().find(named).copied().ok_or_else(|| {
        let names = KINDS.map(|kind| kind.about().name);
        format!("one of {} is expected, found `{name}`", names.join(", "))
    })
}
