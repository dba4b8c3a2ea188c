//! Hardware stamps: captured edges give the end of the right frame, or no stamp.

mod disturbed;
mod line;
#[path = "../random/mod.rs"]
mod random;
mod sound;
mod traffic;
