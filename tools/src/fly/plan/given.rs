//! Faults and criteria that the user gives: checked against the boards and the length of the flight.

use super::Plan;
use crate::fly::command::Command;
use crate::fly::criterion::{Criterion, Must};
use crate::fly::fault::{Cause, Fault};
use crate::images::support::misuse::Misuse;
use crate::images::support::node::Node;

impl Plan {
    /// Checks that each fault is within the flight, and that its nodes and its place are there.
    pub(super) fn check_faults(&self) -> Result<(), Misuse> {
        for Fault { at, cause, origin } in &self.faults {
            let wrong = |cause: String| Err(Misuse::of("fly", format!("{origin}: {cause}")));
            let (second, end) = (at.as_secs_f64(), self.end.as_secs_f64());
            if *at > self.end {
                return wrong(format!("{second} s is after the end of the run; allowed are 0 to {end} s"));
            }
            let Cause::Command(command) = cause else { continue };
            if let Some(node) = command.nodes().iter().find(|node| !self.has(**node)) {
                return wrong(format!("there is no node {node}; {}", self.allowed_nodes()));
            }
            let places = || self.boards.iter().map(|board| board.position_m);
            let (first, last) = (places().fold(f64::MAX, f64::min), places().fold(0.0, f64::max));
            if let Command::Cut { metres, .. } = command
                && !(first < *metres && *metres <= last)
            {
                return wrong(format!(
                    "a break at {metres} m separates nothing; the boards are between {first:.1} m and {last:.1} m, allowed are places \
                     behind the first one, up to the last one"
                ));
            }
        }
        Ok(())
    }

    /// Checks that the node and the time of each criterion are in the flight.
    pub(super) fn check_criteria(&self) -> Result<(), Misuse> {
        for Criterion { node, must, origin } in &self.criteria {
            let wrong = |cause: String| Err(Misuse::of("fly", format!("{origin}: {cause}")));
            if !self.has(*node) {
                return wrong(format!("there is no node {node}; {}", self.allowed_nodes()));
            }
            if let Must::OperationalAt(at) = must
                && *at > self.end
            {
                let (second, end) = (at.as_secs_f64(), self.end.as_secs_f64());
                return wrong(format!("{second} s is after the end of the run; allowed are 0 to {end} s"));
            }
        }
        Ok(())
    }

    fn has(&self, node: Node) -> bool {
        self.boards.iter().any(|board| board.node == node)
    }

    fn allowed_nodes(&self) -> String {
        let nodes: Vec<String> = self.boards.iter().map(|board| board.node.to_string()).collect();
        format!("allowed are {}", nodes.join(", "))
    }

    /// Returns whether the plan takes away the power of a board or resets it: its counters begin again then.
    pub fn restarts(&self, node: Node) -> bool {
        let of = |fault: &Fault| match fault.cause {
            Cause::Command(Command::Power { node, .. } | Command::Reset { node }) => Some(node),
            _ => None,
        };
        self.faults.iter().any(|fault| of(fault) == Some(node))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::options::Options;

    fn refused(options: &Options) -> String {
        Plan::new(options).expect_err("a mistake").to_string()
    }

    #[test]
    fn fault_outside_of_the_flight_is_refused_with_its_origin() {
        for (fault, said) in [
            ("41 reset 3", "after the end of the run; allowed are 0 to 40 s"),
            ("1 power 9 off", "there is no node 9; allowed are 1, 2, 3, 4"),
            ("1 flip nominal 3 2 8", "there is no node 8"),
            ("1 cut nominal 500", "separates nothing"),
            ("1 cut nominal 0", "separates nothing"),
        ] {
            let options = Options { faults: vec![fault.parse().unwrap()], ..Options::default() };
            let error = refused(&options);
            assert!(error.starts_with(&format!("--fault \"{fault}\": ")) && error.contains(said), "{error}");
        }
    }

    #[test]
    fn fault_of_the_user_replaces_those_of_the_demonstration() {
        let faults = vec!["1 reset 3".parse().unwrap()];
        let plan = Plan::new(&Options { faults, ..Options::default() }).unwrap();
        assert_eq!((plan.faults.len(), plan.cut()), (1, None));
        assert!(plan.restarts(3) && !plan.restarts(2));
    }

    #[test]
    fn criterion_outside_of_the_flight_is_refused_with_its_origin() {
        use can_twin::wire::time::Time;
        for (node, second, said) in [(9, 1, "there is no node 9"), (3, 50, "allowed are 0 to 40 s")] {
            let must = Must::OperationalAt(Time::from_ms(1_000 * second));
            let criteria = vec![Criterion { node, must, origin: "m.toml:3: criterion[0]".into() }];
            let error = refused(&Options { criteria, ..Options::default() });
            assert!(error.starts_with("m.toml:3: criterion[0]: ") && error.contains(said), "{error}");
        }
    }
}
