//! Telemetry of the demonstration mission as text: meaning of the two-byte codes and their values.

/// Telemetry code of the stamp source of a slave.
const STAMP_SOURCE: u16 = 0x0104;

/// Formats a reply; `value` is the data after the code, little-endian.
pub fn text(code: u16, value: u64) -> String {
    let field = |from: u32, bits: u32| value >> from & ((1 << bits) - 1);
    let bus = if code & 1 == 0 { "nominal" } else { "redundant" };
    match code {
        0x0101 => format!("up for {:.3} s", value as f64 / 1e3),
        0x0102 => format!("value kept: {value}"),
        0x0103 => match field(32, 16) {
            0 => format!("{} commands executed", field(0, 32)),
            repeats => format!("{} commands executed, {repeats} repeats dropped", field(0, 32)),
        },
        STAMP_SOURCE => match value {
            1 => "stamped its last SYNC in the interrupt".into(),
            2 => "stamped its last SYNC by a captured edge".into(),
            _ => "has stamped no SYNC yet".into(),
        },
        0x0110 | 0x0111 => format!("{bus} bus: {} frames received, {} sent", field(0, 24), field(24, 24)),
        0x0120 | 0x0121 => {
            let (lost, malformed, failed) = (field(0, 16), field(16, 16), field(32, 16));
            format!("{bus} bus: {lost} frames lost, {malformed} malformed, {failed} not sent")
        }
        0x0130 | 0x0131 => {
            let state = match field(0, 8) {
                0 => "error active",
                1 => "error passive",
                2 => "bus-off",
                _ => "in an unknown error state",
            };
            format!("{bus} bus: {state}, TEC {}, REC {}", field(8, 8), field(16, 8))
        }
        _ => format!("{code:04X}h: {value}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replies_read_like_sentences() {
        assert_eq!(text(0x0101, 12_345), "up for 12.345 s");
        assert_eq!(text(0x0103, 7), "7 commands executed");
        assert_eq!(text(0x0103, 0x0002_0000_0007), "7 commands executed, 2 repeats dropped");
        assert_eq!(text(0x0111, 0x0000_0500_0003), "redundant bus: 3 frames received, 5 sent");
        assert_eq!(text(0x0120, 0x0003_0002_0001), "nominal bus: 1 frames lost, 2 malformed, 3 not sent");
        assert_eq!(text(0x0130, 0x03_05_80_01), "nominal bus: error passive, TEC 128, REC 5");
        assert_eq!(text(0x0104, 2), "stamped its last SYNC by a captured edge");
        assert_eq!(text(0x7777, 9), "7777h: 9");
    }
}
