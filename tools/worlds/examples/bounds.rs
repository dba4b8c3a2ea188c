//! Prints how often the error is outside of the reported bound: `cargo run --release -p ecss-can-worlds --example bounds`.

use ecss_can_worlds::local_clock::{Figures, Sample, trials::TRIALS};

fn main() {
    let seeds: u64 = std::env::args().nth(1).map_or(100, |seeds| seeds.parse().expect("a number of seeds"));
    println!("| trial | SYNC | rms, ns | largest, ns | median bound, ns | ratio | outside, % |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for trial in &TRIALS {
        for (rate, period) in [("1 Hz", 1e9), ("10 Hz", 1e8)] {
            let samples: Vec<Sample> = (0..seeds).flat_map(|seed| trial.run(seed, period)).collect();
            let outside = samples.iter().filter(|sample| sample.error.abs() > sample.bound).count();
            let settled = || samples.iter().filter(|sample| sample.time >= 30.0);
            let figures = Figures::of(settled().map(|sample| sample.error));
            let mut bounds: Vec<f64> = settled().map(|sample| sample.bound).collect();
            bounds.sort_by(f64::total_cmp);
            let median = bounds[bounds.len() / 2];
            let (rms, ratio) = (figures.rms, median / figures.rms);
            let share = 100.0 * outside as f64 / samples.len() as f64;
            println!(
                "| {} | {rate} | {rms:.1} | {:.0} | {median:.0} | {ratio:.1} | {share:.4} |",
                trial.name, figures.worst
            );
        }
    }
}
