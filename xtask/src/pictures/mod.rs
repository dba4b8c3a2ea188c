//! `cargo xtask pictures`: the pictures of the documentation that show measurements.
//!
//! Waveforms, clocks and fail-over times are simulated without firmware, and a test compares their files with the
//! present output of the code. The others are of flights of the images.

mod clocks;
mod failover;
mod flights;
mod waveforms;

use anyhow::Context;

/// Returns names and contents of the pictures that need no images.
fn simulated() -> anyhow::Result<Vec<(&'static str, String)>> {
    Ok([waveforms::pictures()?, clocks::pictures(), failover::pictures()].concat())
}

/// Writes all pictures.
pub fn run() -> anyhow::Result<()> {
    write(simulated()?)?;
    for draw in flights::PICTURES {
        write(draw()?)?;
    }
    Ok(())
}

fn write(pictures: Vec<(&'static str, String)>) -> anyhow::Result<()> {
    for (file, content) in pictures {
        let path = ecss_can_cli::images::support::project::path("docs").join(file);
        std::fs::write(&path, content).with_context(|| format!("writing {}", path.display()))?;
        ecss_can_cli::images::support::output::line(path.display())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simulated_pictures_of_the_documentation_are_current() {
        for (file, content) in simulated().unwrap() {
            let path = ecss_can_cli::images::support::project::path("docs").join(file);
            let committed = std::fs::read_to_string(&path).unwrap_or_default();
            let is_current = committed.replace("\r\n", "\n") == content;
            assert!(is_current, "docs/{file} is not current: run `cargo xtask pictures`");
        }
    }
}
