//! Values as text, and how they follow the Node-ID.

use ecss_can::od::DataType;
use ecss_can::types::NodeId;

use crate::Error;
use crate::file::checked;

/// What an entry has after power-on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Default {
    /// Nobody reads it, or it is a block of bytes.
    None,
    /// The same on every node.
    Same(Vec<u8>),
    /// This number plus the Node-ID.
    Follows(u64),
    /// It differs in another way.
    Varies,
}

impl Default {
    /// From the values that nodes have.
    pub fn of(data_type: DataType, values: &[(NodeId, Vec<u8>)]) -> Default {
        let Some((node, first)) = values.first() else { return Default::None };
        if values.iter().all(|(_, value)| value == first) {
            return Default::Same(first.clone());
        }
        let offset = |node: &NodeId, value: &[u8]| number(value).checked_sub(node.get().into());
        match offset(node, first) {
            Some(common)
                if is_unsigned(data_type)
                    && values.iter().all(|(node, value)| offset(node, value) == Some(common)) =>
            {
                Default::Follows(common)
            }
            _ => Default::Varies,
        }
    }

    /// As an EDS has it. `None`: it has none, or it is empty or zero and of a type that some readers do not know.
    pub fn text(&self, data_type: DataType) -> Result<Option<String>, Error> {
        match self {
            Default::None | Default::Varies => Ok(None),
            Default::Same(value) if is_rare(data_type) && value.iter().all(|byte| *byte == 0) => Ok(None),
            Default::Same(value) => text(data_type, value).map(Some),
            Default::Follows(offset) => Ok(Some(format!("$NODEID+0x{offset:X}"))),
        }
    }

    /// Whether a reader of the EDS knows that this node has this value.
    pub fn tells(&self, node: NodeId, value: &[u8]) -> bool {
        match self {
            Default::None | Default::Varies => false,
            Default::Same(same) => same == value,
            Default::Follows(offset) => number(value) == offset + u64::from(node.get()),
        }
    }
}

/// A value as both files have it.
pub fn text(data_type: DataType, value: &[u8]) -> Result<String, Error> {
    Ok(match data_type {
        DataType::VisibleString => plain(String::from_utf8_lossy(value).into_owned())?,
        DataType::UnicodeString => {
            let units: Vec<u16> = value.chunks_exact(2).map(|unit| number(unit) as u16).collect();
            plain(String::from_utf16_lossy(&units))?
        }
        DataType::OctetString => value.iter().map(|byte| format!("{byte:02X}")).collect(),
        DataType::Real32 => real(f32::from_bits(number(value) as u32)),
        DataType::Real64 => real(f64::from_bits(number(value))),
        DataType::Boolean => number(value).to_string(),
        _ if data_type.is_signed() => {
            let unused = 64 - 8 * value.len().clamp(1, 8);
            ((number(value) << unused) as i64 >> unused).to_string()
        }
        _ => hexadecimal(data_type, number(value)),
    })
}

/// Decimal. Zero has no point: it is the one value that readers of bit patterns understand as well.
fn real(value: impl std::fmt::Debug) -> String {
    let text = format!("{value:?}");
    match text.as_str() {
        "0.0" | "-0.0" => text.trim_end_matches(".0").into(),
        _ => text,
    }
}

/// Types that some readers do not know. Those refuse a file that gives such a value a default, and take a value without one
/// for zero or empty.
fn is_rare(data_type: DataType) -> bool {
    use DataType as T;
    matches!(
        data_type,
        T::Integer24
            | T::Integer40
            | T::Integer48
            | T::Integer56
            | T::Unsigned24
            | T::Unsigned40
            | T::Unsigned48
            | T::Unsigned56
            | T::UnicodeString
    )
}

/// A limit as both files have it.
pub fn limit(data_type: DataType, limit: i64) -> String {
    if data_type.is_signed() { limit.to_string() } else { hexadecimal(data_type, limit as u64) }
}

fn hexadecimal(data_type: DataType, number: u64) -> String {
    format!("0x{number:0digits$X}", digits = 2 * data_type.size().unwrap_or(1))
}

fn is_unsigned(data_type: DataType) -> bool {
    use DataType as T;
    matches!(
        data_type,
        T::Unsigned8
            | T::Unsigned16
            | T::Unsigned24
            | T::Unsigned32
            | T::Unsigned40
            | T::Unsigned48
            | T::Unsigned56
            | T::Unsigned64
    )
}

/// The number in up to eight bytes.
pub fn number(value: &[u8]) -> u64 {
    value.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}

fn plain(text: String) -> Result<String, Error> {
    checked(&text).map(|()| text)
}
