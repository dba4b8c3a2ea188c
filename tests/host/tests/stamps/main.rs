//! Hardware stamps: from captured edges to the end of the right frame, or to none.

mod disturbed;
mod line;
mod sound;
mod traffic;
