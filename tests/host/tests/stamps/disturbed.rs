//! Lines with faults: no stamp rather than one of another frame.
