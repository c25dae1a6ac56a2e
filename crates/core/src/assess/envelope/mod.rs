//! The safe-release envelope: how far from the nominal release what a drop begins with may be, two quantities
//! at a time, until J_state no longer stays below a limit in 99 % of the flights with 95 % confidence.
//!
//! From the nominal release a fan of rays goes outwards in the plane of two quantities, and along each the
//! edge is searched. A point counts as safe when every one of [`EdgeSearch::flights`] flights about it stays
//! below the limit: were one flight in a hundred unsafe, so many would all be safe less often than one time
//! in twenty. Since the search picks the farthest such point, it flatters it; therefore each edge is tried
//! again on releases that no search has seen, and stepped back from until one of few points that were fixed
//! beforehand holds. That point is the confirmed one.
//!
//! | file | holds |
//! |---|---|
//! | [`axes`] | the quantities, the points and the rays |
//! | [`search`] | the edge along a ray, of any flights |
//! | [`flights`] | flights of the cascade, broken off at the limit |

pub mod axes;
pub mod flights;
pub mod search;

pub use axes::{AxisRange, EnvelopeAxis, EnvelopePoint, Fan, Ray, Reaches, reaches_of};
pub use flights::EnvelopeFlights;
pub use search::{Edge, EdgeSearch, RayFlights, Stopped, flights_for};
