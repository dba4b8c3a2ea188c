//! Hardware stamps: from captured edges to the end of the right frame, or to none.

mod disturbed;
mod line;
#[path = "../random/mod.rs"]
mod random;
mod sound;
mod traffic;
