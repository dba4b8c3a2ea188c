//! The campaign detects each broken rule.

use ecss_can_cli::campaign::broken::fly;
use ecss_can_cli::campaign::rule::Rule;
use ecss_can_cli::campaign::script::Script;
use ecss_can_cli::campaign::{World, fly as fly_whole};

/// Part of the violation for each broken rule, and the simplest script of its run.
const FOUND: [(Rule, &str, &str); 6] = [
    (
        Rule::DeadBus,
        "slaves are reached on the other bus only",
        "run seed=1 slaves=2 length=60000000\ncut at=12000000 place=3\nreset-master at=20000000\n",
    ),
    (
        Rule::Repeats,
        "executed command",
        "run seed=1 slaves=2 length=60000000\nflip at=11000000 node=1 value=66 times=4\n",
    ),
    (
        Rule::OneNodeId,
        "node 2 did not report another one with its Node-ID",
        "run seed=1 slaves=2 length=60000000\nclash at=17000000 node=2 value=5 times=1 every=1000000\n",
    ),
    (
        Rule::Repeats,
        "executed command",
        "run seed=1 masters=2 slaves=2 length=60000000\nflip at=11000000 node=1 value=66 times=4\n",
    ),
    (
        Rule::OneMaster,
        "two masters that hear each other are active",
        "run seed=1 masters=2 slaves=2 length=60000000\n\
         disconnect at=16000000 lasts=1000000 node=128\n\
         disconnect at=16000000 lasts=1000000 bus=redundant node=128\n",
    ),
    (
        Rule::Claims,
        "two masters that hear each other are active",
        "run seed=1 masters=2 slaves=2 length=60000000\ndisconnect at=20000000 node=128\n",
    ),
];

/// Given the simplest script of each rule, when the rule is broken, then the campaign detects it; otherwise there is no
/// violation.
#[test]
fn each_broken_rule_is_found() {
    for (rule, reason, text) in FOUND {
        let script: Script = text.parse().unwrap();
        let found = fly(rule, &script).violations;
        assert!(found.iter().any(|violation| violation.contains(reason)), "{rule:?}: {found:?}");
        assert_eq!(fly_whole(World::Host, &script).violations, <Vec<String>>::new(), "{rule:?}");
    }
}
