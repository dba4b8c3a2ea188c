//! Shared code of the commands: boards with their images, images as files, output and endings, counters of an image,
//! shards of long runs.

pub mod board;
pub mod counters;
pub mod diagnostics;
pub mod elf;
pub mod ending;
pub mod fleet;
pub mod misuse;
pub mod needs;
pub mod node;
pub mod output;
pub mod project;
pub mod shard;
pub mod stop;
