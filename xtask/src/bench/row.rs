//! One figure of the benchmarks: its name, value, unit and target.

use serde::Serialize;
use serde_json::Number;

/// A figure. Its area stands before its name in the summary: `load.frames`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name within its area. It is the key of the row and not written with it.
    #[serde(skip)]
    pub name: String,
    /// Measured value.
    pub value: Number,
    /// Unit of the value and the target.
    pub unit: &'static str,
    /// Direction of improvement.
    pub better: Better,
    /// The bound that the value must not pass, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<Number>,
    /// Whether the target is met, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds: Option<bool>,
    /// Whether it varies between runs, because it is based on wall-clock times.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub noisy: bool,
}

/// Which values are better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Better {
    /// Lower values are better.
    Lower,
    /// Higher values are better.
    Higher,
}

impl Row {
    /// Makes a figure that should be small.
    pub fn lower(name: impl Into<String>, value: impl Figure, unit: &'static str) -> Row {
        let (name, value, better) = (name.into(), value.number(), Better::Lower);
        Row { name, value, unit, better, target: None, holds: None, noisy: false }
    }

    /// Makes a figure that should be large.
    pub fn higher(name: impl Into<String>, value: impl Figure, unit: &'static str) -> Row {
        Row { better: Better::Higher, ..Row::lower(name, value, unit) }
    }

    /// Adds a bound that the value must not pass.
    pub fn within(self, target: impl Figure) -> Row {
        let target = target.number();
        let holds = self.value.as_f64().zip(target.as_f64()).map(|(value, target)| match self.better {
            Better::Lower => value <= target,
            Better::Higher => value >= target,
        });
        Row { target: Some(target), holds, ..self }
    }

    /// Adds a bound, if there is one.
    pub fn within_any(self, target: Option<impl Figure>) -> Row {
        match target {
            Some(target) => self.within(target),
            None => self,
        }
    }

    /// Marks it as based on wall-clock times.
    pub fn noisy(self) -> Row {
        Row { noisy: true, ..self }
    }
}

/// A value of a row. Whole numbers are unchanged, others have three decimals.
pub trait Figure {
    /// Converts it to JSON.
    fn number(self) -> Number;
}

impl Figure for u64 {
    fn number(self) -> Number {
        self.into()
    }
}

impl Figure for f64 {
    /// NaN, a ratio of nothing, becomes 0.
    fn number(self) -> Number {
        Number::from_f64((self * 1e3).round() / 1e3).unwrap_or_else(|| 0.into())
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_row_is_written_as_the_format_says() {
        let row = Row::lower("latency", 1234, "model_cycles").within(1500);
        let expected =
            json!({"value": 1234, "unit": "model_cycles", "target": 1500, "better": "lower", "holds": true});
        assert_eq!(serde_json::to_value(&row).unwrap(), expected);
        let row = Row::higher("speed", 2.34567, "times").noisy();
        let expected = json!({"value": 2.346, "unit": "times", "better": "higher", "noisy": true});
        assert_eq!(serde_json::to_value(&row).unwrap(), expected);
    }

    #[test]
    fn a_target_may_be_reached_and_not_passed() {
        let lower = |value: u64| Row::lower("x", value, "bytes").within(10).holds;
        assert_eq!([lower(9), lower(10), lower(11)], [Some(true), Some(true), Some(false)]);
        let higher = |value: f64| Row::higher("x", value, "percent").within(95.0).holds;
        assert_eq!([higher(94.9), higher(95.0), higher(99.0)], [Some(false), Some(true), Some(true)]);
        assert_eq!(Row::lower("x", 1, "bytes").holds, None);
    }
}
