//! Random cases of property tests.

use proptest::prelude::ProptestConfig;
use proptest::test_runner::RngSeed;

/// Returns the configuration for `count` random cases, the same in each run. PROPTEST_CASES and PROPTEST_RNG_SEED
/// change number and seed.
pub fn cases(count: u32) -> ProptestConfig {
    let rng_seed = RngSeed::Fixed(11898);
    ProptestConfig { cases: count, failure_persistence: None, rng_seed, ..ProptestConfig::default() }
}
