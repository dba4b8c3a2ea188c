//! The two tables of the standard that we answer, and how we interpret it, as rows.

use serde::Deserialize;

/// A requirement of ECSS-E-ST-50-15C.
#[derive(Clone, Debug, Deserialize)]
pub struct Requirement {
    /// As in the standard, with the number of an item of a list: `8.3.3b.1`.
    pub id: String,
    /// Who meets it.
    pub who: Who,
    /// Whether it applies to a system with this software and these boards.
    pub applies: Applies,
    /// How it is verified; `None` if it does not apply or is a permission.
    pub method: Option<Method>,
    /// Page or folder in `docs` that helps to meet it, with an anchor or without; may be empty. Software has tests instead.
    pub page: String,
    /// What it asks for, in our words.
    #[serde(rename = "requirement")]
    pub text: String,
    /// A reason, or our reading; may be empty.
    pub remark: String,
}

impl Requirement {
    /// Returns the number of its clause: `8` of `8.3.3b.1`.
    pub fn clause(&self) -> &str {
        self.id.split('.').next().unwrap_or_default()
    }
}

impl Requirement {
    /// Returns its interpretations of a kind.
    pub fn interpreted<'a>(
        &self,
        all: &'a [Interpretation],
        kind: Kind,
    ) -> impl Iterator<Item = &'a Interpretation> {
        all.iter().filter(move |one| one.id == self.id && one.kind == kind)
    }
}

/// How we interpret a requirement, where more than its text is needed to say what the software does.
#[derive(Clone, Debug, Deserialize)]
pub struct Interpretation {
    /// Requirement. One may have several interpretations.
    pub id: String,
    /// How far the software is from the text.
    pub kind: Kind,
    /// One short sentence.
    pub text: String,
    /// Page with the decision, from `docs`, with an anchor or without.
    pub page: String,
}

/// A requirement that sums up others: the tests of these verify it too, beside its own.
#[derive(Clone, Debug, Deserialize)]
pub struct Summary {
    /// Requirement.
    pub id: String,
    /// Clauses, or requirements, with blanks between: `5.6.2 8.3`.
    pub clauses: String,
    /// How they meet it, in a sentence.
    pub reason: String,
}

impl Summary {
    /// Returns whether it sums up this requirement.
    pub fn has(&self, id: &str) -> bool {
        self.clauses.split(' ').any(|clause| {
            id.strip_prefix(clause).is_some_and(|rest| !rest.starts_with(|next: char| next.is_ascii_digit()))
        })
    }
}

/// How far an interpretation is from the text of its requirement.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The text is unclear, or contradicts another one, and we take it in one way.
    Reading,
    /// We meet the text and do more than it asks for.
    Extension,
    /// We do not do all that the text says (ECSS-S-ST-00-01C: deviation). The customer has to agree.
    Deviation,
}

/// Who meets a requirement.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Who {
    /// This software; a test shows it.
    Software,
    /// The hardware of a node.
    Board,
    /// Who builds the network, or agrees on values.
    Integrator,
}

/// Whether a requirement applies.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Applies {
    /// It applies.
    Yes,
    /// It does not apply: the remark names the clause that permits this.
    No,
    /// It is a permission, so there is nothing to verify.
    May,
}

/// Method of verification, as ECSS-E-ST-10-02 has it.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
pub enum Method {
    /// Test.
    T,
    /// Analysis.
    A,
    /// Review of design.
    R,
    /// Inspection.
    I,
}

/// A section of CiA 301 in Table 11-1 of the standard.
#[derive(Clone, Debug, Deserialize)]
pub struct Clause {
    /// Of CiA 301.
    pub section: String,
    /// What it is about.
    pub subject: String,
    /// `A` applicable, `O` optional, `NA` not used, `R` for reference.
    pub applicability: String,
    /// What we have.
    pub ours: String,
    /// Why we have less or more than the table asks for; empty if we do not.
    pub reason: String,
}

/// All requirements, in the order of the standard.
pub fn requirements() -> Vec<Requirement> {
    rows(include_str!("../../compliance/data/requirements.csv"))
}

/// All interpretations, in the order of the standard.
pub fn interpretations() -> Vec<Interpretation> {
    rows(include_str!("../../compliance/data/interpretations.csv"))
}

/// The requirements that sum up others, in the order of the standard.
pub fn summaries() -> Vec<Summary> {
    rows(include_str!("../../compliance/data/summaries.csv"))
}

/// Table 11-1, in its order.
pub fn clauses() -> Vec<Clause> {
    rows(include_str!("../../compliance/data/table_11_1.csv"))
}

/// The tables are part of this program: one that cannot be read is an error of it, and a test reads both.
fn rows<T: for<'row> Deserialize<'row>>(text: &str) -> Vec<T> {
    let rows = csv::Reader::from_reader(text.as_bytes()).into_deserialize();
    rows.collect::<Result<_, _>>().unwrap_or_else(|error| panic!("a table of requirements: {error}"))
}
