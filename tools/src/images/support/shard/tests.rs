use serde_json::json;

use super::*;

#[test]
fn shard_is_a_number_of_a_count() {
    assert_eq!("3/16".parse(), Ok(Shard { index: 3, count: 16 }));
    for wrong in ["0/4", "5/4", "1", "a/b", "1/0", "-1/4", "1/99999999", "1/2/3", ""] {
        assert!(wrong.parse::<Shard>().is_err_and(|error| error.contains("3/16")), "{wrong}");
    }
}

#[test]
fn shares_of_all_shards_are_each_unit_once_in_order() {
    let shares = |total: u64, count: u64| -> Vec<Range<u64>> {
        (1..=count).map(|index| Shard { index, count }.share(total)).collect()
    };
    assert_eq!(shares(10, 4), [0..2, 2..5, 5..7, 7..10]);
    assert_eq!(shares(3, 3), [0..1, 1..2, 2..3]);
    for (total, count) in [(1, 1), (7, 3), (400, 64), (u64::MAX, 5)] {
        let shares = shares(total, count);
        assert!(shares.windows(2).all(|pair| pair[0].end == pair[1].start));
        assert_eq!((shares[0].start, shares.last().unwrap().end), (0, total));
    }
}

#[test]
fn more_shards_than_units_are_refused() {
    let four = Shard { index: 1, count: 4 };
    assert_eq!(four.check("campaign", 4, "runs"), Ok(()));
    let error = four.check("campaign", 3, "runs").unwrap_err().to_string();
    assert!(error.contains("4 shards of 3 runs") && error.contains("allowed are 1 to 3"), "{error}");
}

/// A folder with parts of a run of two shards.
struct Parts(tempfile::TempDir);

impl Parts {
    fn new() -> Parts {
        Parts(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, run: Run<Value>, shard: u64) -> PathBuf {
        let path = self.path(name);
        Part { run, shard, results: vec![format!("result {shard}")] }.write(&path).unwrap();
        path
    }
}

fn run() -> Run<Value> {
    let parameters = json!({ "seed": 1, "by_clause": false });
    Run { command: "sample".into(), commit: "abc".into(), shards: 2, parameters }
}

fn merge(files: &[&PathBuf]) -> Result<Vec<String>, String> {
    let files: Vec<PathBuf> = files.iter().copied().cloned().collect();
    let merged: anyhow::Result<(Run<Value>, Vec<Vec<String>>)> = merged("sample", &files);
    merged.map(|(_, results)| results.concat()).map_err(|error| error.to_string())
}

#[test]
fn results_are_in_the_order_of_the_shards() {
    let parts = Parts::new();
    let (one, two) = (parts.write("1.json", run(), 1), parts.write("2.json", run(), 2));
    assert_eq!(merge(&[&two, &one]), Ok(vec!["result 1".into(), "result 2".into()]));
}

#[test]
fn missing_and_double_shards_are_named() {
    let parts = Parts::new();
    let (one, again) = (parts.write("1.json", run(), 1), parts.write("again.json", run(), 1));
    let error = merge(&[&one]).unwrap_err();
    assert!(error.ends_with("\n  of 2 shards these are missing: 2"), "{error}");
    let error = merge(&[&one, &again]).unwrap_err();
    assert!(error.contains("again.json: shard 1 is already in ") && error.contains("missing: 2"), "{error}");
}

#[test]
fn part_of_another_run_is_named_with_the_difference() {
    let parts = Parts::new();
    let one = parts.write("1.json", run(), 1);
    let others = [
        (Run { commit: "def".into(), ..run() }, "commit abc there, def here"),
        (Run { shards: 3, ..run() }, "number of shards 2 there, 3 here"),
        (Run { parameters: json!({ "seed": 2, "by_clause": false }), ..run() }, "seed 1 there, 2 here"),
        (
            Run { parameters: json!({ "seed": 1, "by_clause": true }), ..run() },
            "by clause false there, true here",
        ),
        (Run { parameters: json!({ "seed": 1 }), ..run() }, "another run than"),
        (Run { command: "other".into(), ..run() }, "of `other`, not of `sample`"),
    ];
    for (other, expected) in others {
        let other = parts.write("other.json", other, 2);
        let error = merge(&[&one, &other]).unwrap_err();
        assert!(error.contains("other.json: ") && error.contains(expected), "{expected}: {error}");
        assert!(error.contains("missing: 2"), "{error}");
    }
}

#[test]
fn file_that_is_no_part_is_named_and_its_shard_is_missing() {
    let parts = Parts::new();
    let (one, two) = (parts.write("1.json", run(), 1), parts.write("2.json", run(), 2));
    let whole = fs::read(&two).unwrap();
    for length in [0, 1, whole.len() / 2, whole.len() - 3] {
        fs::write(&two, &whole[..length]).unwrap();
        let error = merge(&[&one, &two]).unwrap_err();
        assert!(error.contains("2.json: no part of a run of `sample`"), "{length}: {error}");
        assert!(error.contains("missing: 2"), "{length}: {error}");
    }
    let error = merge(&[&one, &parts.path("nowhere.json")]).unwrap_err();
    assert!(error.contains("nowhere.json: No such file") && error.contains("missing: 2"), "{error}");
    let error = merge(&[&parts.write("3.json", run(), 3)]).unwrap_err();
    assert!(error.contains("3.json: shard 3 of 2"), "{error}");
}

/// Given the part of an earlier run, when a shard prepares and fails, then no part is left.
#[test]
fn preparing_removes_the_part_of_an_earlier_run() {
    let parts = Parts::new();
    let one = parts.write("1.json", run(), 1);
    prepare("campaign", &one).unwrap();
    assert_eq!(fs::read_dir(parts.0.path()).unwrap().count(), 0);
    prepare("campaign", &parts.path("new/folder/1.json")).unwrap();
    fs::write(&one, "in the way").unwrap();
    let error = prepare("campaign", &one.join("below/1.json")).unwrap_err().to_string();
    assert!(error.starts_with("--out: cannot write ") && error.contains("can be written"), "{error}");
}
