//! Random cases of property tests.

use proptest::prelude::ProptestConfig;
use proptest::test_runner::RngSeed;

/// `count` random cases, the same each time. PROPTEST_CASES and PROPTEST_RNG_SEED make more and other ones.
pub fn cases(count: u32) -> ProptestConfig {
    let rng_seed = RngSeed::Fixed(301);
    ProptestConfig { cases: count, failure_persistence: None, rng_seed, ..ProptestConfig::default() }
}
