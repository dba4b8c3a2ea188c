//! Data types of the object dictionary (CiA 301 7.4.7).

/// Data type, with its index in the dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum DataType {
    /// BOOLEAN: one bit in a PDO, one byte in an SDO.
    Boolean = 0x01,
    /// INTEGER8: two's complement, 8 bits.
    Integer8 = 0x02,
    /// INTEGER16: two's complement, 16 bits.
    Integer16 = 0x03,
    /// INTEGER32: two's complement, 32 bits.
    Integer32 = 0x04,
    /// UNSIGNED8: unsigned, 8 bits.
    Unsigned8 = 0x05,
    /// UNSIGNED16: unsigned, 16 bits.
    Unsigned16 = 0x06,
    /// UNSIGNED32: unsigned, 32 bits.
    Unsigned32 = 0x07,
    /// REAL32: IEEE 754 single precision.
    Real32 = 0x08,
    /// VISIBLE_STRING: ASCII characters.
    VisibleString = 0x09,
    /// OCTET_STRING: any bytes.
    OctetString = 0x0A,
    /// UNICODE_STRING: UTF-16 code units.
    UnicodeString = 0x0B,
    /// TIME_OF_DAY: milliseconds since midnight, days since 1984-01-01.
    TimeOfDay = 0x0C,
    /// TIME_DIFFERENCE: milliseconds and days.
    TimeDifference = 0x0D,
    /// DOMAIN: a block of bytes that moves in parts.
    Domain = 0x0F,
    /// INTEGER24: two's complement, 24 bits.
    Integer24 = 0x10,
    /// REAL64: IEEE 754 double precision.
    Real64 = 0x11,
    /// INTEGER40: two's complement, 40 bits.
    Integer40 = 0x12,
    /// INTEGER48: two's complement, 48 bits.
    Integer48 = 0x13,
    /// INTEGER56: two's complement, 56 bits.
    Integer56 = 0x14,
    /// INTEGER64: two's complement, 64 bits.
    Integer64 = 0x15,
    /// UNSIGNED24: unsigned, 24 bits.
    Unsigned24 = 0x16,
    /// UNSIGNED40: unsigned, 40 bits.
    Unsigned40 = 0x18,
    /// UNSIGNED48: unsigned, 48 bits.
    Unsigned48 = 0x19,
    /// UNSIGNED56: unsigned, 56 bits.
    Unsigned56 = 0x1A,
    /// UNSIGNED64: unsigned, 64 bits.
    Unsigned64 = 0x1B,
}

impl DataType {
    /// Returns the index of the type in the dictionary (DEFTYPE).
    pub const fn index(self) -> u16 {
        self as u16
    }

    /// Returns the number of bytes of a value over SDO. `None` if it depends on the value.
    pub const fn size(self) -> Option<usize> {
        use DataType as T;
        Some(match self {
            T::Boolean | T::Integer8 | T::Unsigned8 => 1,
            T::Integer16 | T::Unsigned16 => 2,
            T::Integer24 | T::Unsigned24 => 3,
            T::Integer32 | T::Unsigned32 | T::Real32 => 4,
            T::Integer40 | T::Unsigned40 => 5,
            T::Integer48 | T::Unsigned48 | T::TimeOfDay | T::TimeDifference => 6,
            T::Integer56 | T::Unsigned56 => 7,
            T::Integer64 | T::Unsigned64 | T::Real64 => 8,
            T::VisibleString | T::OctetString | T::UnicodeString | T::Domain => return None,
        })
    }

    /// Returns the number of bits of a value in a PDO, `1..=64`. `None` if the type cannot be mapped.
    pub const fn bits(self) -> Option<u8> {
        match (self, self.size()) {
            (DataType::Boolean, _) => Some(1),
            (_, Some(bytes)) => Some(bytes as u8 * 8),
            (_, None) => None,
        }
    }

    /// Returns whether the type has values below zero.
    pub const fn is_signed(self) -> bool {
        use DataType as T;
        matches!(
            self,
            T::Integer8
                | T::Integer16
                | T::Integer24
                | T::Integer32
                | T::Integer40
                | T::Integer48
                | T::Integer56
                | T::Integer64
        )
    }

    /// Returns whether the values are whole numbers.
    pub const fn is_integer(self) -> bool {
        use DataType as T;
        let unsigned = matches!(
            self,
            T::Unsigned8
                | T::Unsigned16
                | T::Unsigned24
                | T::Unsigned32
                | T::Unsigned40
                | T::Unsigned48
                | T::Unsigned56
                | T::Unsigned64
        );
        unsigned || self.is_signed()
    }

    /// Returns the type of a dummy entry of a receive PDO. Such an entry is mapped by the index of its type (CiA
    /// 301 7.4.8.2).
    pub const fn of_dummy(index: u16) -> Option<DataType> {
        Some(match index {
            0x01 => DataType::Boolean,
            0x02 => DataType::Integer8,
            0x03 => DataType::Integer16,
            0x04 => DataType::Integer32,
            0x05 => DataType::Unsigned8,
            0x06 => DataType::Unsigned16,
            0x07 => DataType::Unsigned32,
            _ => return None,
        })
    }
}
