//! All kinds of studies. Who adds one adds its folder, its module in `lib.rs`, and its line here.

use crate::effects::Effects;
use crate::envelope::Envelope;
use crate::free_fall::FreeFall;
use crate::kind::Kind;
use crate::rare::Rare;
use crate::replan::Replan;
use crate::sobol::Sobol;

/// The kinds, in the order in which they are offered.
pub const KINDS: [&dyn Kind; 6] = [&Effects, &Envelope, &Rare, &Sobol, &Replan, &FreeFall];

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
