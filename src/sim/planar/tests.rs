//! Planar flights against the code for flight in space.
