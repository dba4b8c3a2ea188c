"""SDO transfers of every kind with slaves 2 and 3, test devices, by the canopen package; master is this script."""

import random
import struct
import unittest

from canopen.objectdictionary import datatypes
from canopen.sdo import SdoAbortedError

from spacecraft import Test

STORE = 0x6300
#: What a data store holds at least.
SIZE = 20_000

ABORT = {
    "unknown command": 0x05040001,
    "no object": 0x06020000,
    "too long": 0x06070012,
    "too short": 0x06070013,
    "no sub-index": 0x06090011,
    "invalid value": 0x06090030,
    "too large a value": 0x06090031,
    "too small a value": 0x06090032,
}

#: Values of every type that are not its default; the sub-index is the data type (CiA 301 Table 44).
VALUES = {
    datatypes.BOOLEAN: [True, False],
    datatypes.INTEGER8: [-128, 127],
    datatypes.INTEGER16: [-32768, 32767],
    datatypes.INTEGER24: [-(2**23), 2**23 - 1],
    datatypes.INTEGER32: [-(2**31), 2**31 - 1],
    datatypes.INTEGER40: [-(2**39), 2**39 - 1],
    datatypes.INTEGER48: [-(2**47), 2**47 - 1],
    datatypes.INTEGER56: [-(2**55), 2**55 - 1],
    datatypes.INTEGER64: [-(2**63), 2**63 - 1],
    datatypes.UNSIGNED8: [1, 255],
    datatypes.UNSIGNED16: [1, 65535],
    datatypes.UNSIGNED24: [1, 2**24 - 1],
    datatypes.UNSIGNED32: [1, 2**32 - 1],
    datatypes.UNSIGNED40: [1, 2**40 - 1],
    datatypes.UNSIGNED48: [1, 2**48 - 1],
    datatypes.UNSIGNED56: [1, 2**56 - 1],
    datatypes.UNSIGNED64: [1, 2**64 - 1],
    datatypes.REAL32: [0.5, -2.0**100],
    datatypes.REAL64: [0.1, -1e300],
    datatypes.VISIBLE_STRING: ["a", "twelve chars"],
    datatypes.OCTET_STRING: [b"\x00", bytes(range(0xF4, 0x100))],
    datatypes.UNICODE_STRING: ["\u00e4", "\u03a9\u20ac\u4e16\u754c\ufffd\u0041"],
    # canopen takes them as bytes: milliseconds (28 bits), days (CiA 301 7.1.6.5, 7.1.6.6).
    datatypes.TIME_OF_DAY: [struct.pack("<IH", 1, 0), struct.pack("<IH", 86_399_999, 65535)],
    datatypes.TIME_DIFFERENCE: [struct.pack("<IH", 0, 1), struct.pack("<IH", 12_345_678, 32_768)],
}


class Sdo(Test):
    def setUp(self) -> None:
        self.net = self.connect(is_master=True)
        self.slave, self.other = self.nodes(self.net, 2, 3)
        self.sdo = self.slave.remote.sdo
        self.net.nmt.state = "PRE-OPERATIONAL"

    def aborts(self, code: int, transfer, *arguments) -> None:
        with self.assertRaises(SdoAbortedError) as refusal:
            transfer(*arguments)
        self.assertEqual(refusal.exception.code, code, str(refusal.exception))

    def test_values_of_every_type_are_kept(self) -> None:
        """Expedited up to 4 bytes, segmented above. None is missing."""
        limited = 0x1C
        self.assertEqual({*VALUES, limited}, {sub for sub in self.slave.remote.object_dictionary[0x6400] if sub})
        for data_type, values in VALUES.items():
            for value in values:
                with self.subTest(data_type=f"{data_type:04X}h", value=value):
                    self.sdo[0x6400][data_type].raw = value
                    self.assertEqual(self.sdo[0x6400][data_type].raw, value)
        self.assertEqual(self.other.remote.sdo[0x6400][datatypes.UNSIGNED32].raw, 0)

    def test_what_cannot_be_is_refused_with_its_code(self) -> None:
        limited = 0x6400, 0x1C
        for code, transfer, arguments in [
            ("no object", self.sdo.upload, (0x5FFF, 0)),
            ("no object", self.sdo.download, (0x5FFF, 0, b"\x00")),
            ("no sub-index", self.sdo.upload, (0x1018, 5)),
            ("no sub-index", self.sdo.download, (0x6400, 0xFE, b"\x00")),
            ("too long", self.sdo.download, (0x6400, datatypes.UNSIGNED16, bytes(4))),
            ("too long", self.sdo.download, (0x6400, datatypes.UNSIGNED64, bytes(9))),
            ("too short", self.sdo.download, (0x6400, datatypes.UNSIGNED32, bytes(2))),
            # A BOOLEAN is 0 or 1 (CiA 301 7.1.4.4).
            ("invalid value", self.sdo.download, (0x6400, datatypes.BOOLEAN, b"\x02")),
            ("too large a value", self.sdo.download, (*limited, struct.pack("<h", 101))),
            ("too small a value", self.sdo.download, (*limited, struct.pack("<h", -101))),
        ]:
            with self.subTest(code=code, at=f"{arguments[0]:04X}h"):
                self.aborts(ABORT[code], transfer, *arguments)
        self.sdo.download(*limited, struct.pack("<h", 100))
        self.assertEqual(self.sdo.upload(*limited), struct.pack("<h", 100))

    def test_an_unknown_command_is_aborted(self) -> None:
        self.aborts(ABORT["unknown command"], self.sdo.request_response, bytes([0xE0, 0, 0x10, 0, 0, 0, 0, 0]))

    def test_a_second_request_ends_the_transfer_before_it(self) -> None:
        begin = struct.pack("<BHBI", 0x21, STORE, 0, 100)
        self.assertEqual(self.sdo.request_response(begin)[0], 0x60)
        self.assertEqual(self.sdo.request_response(bytes([0x00]) + bytes(7))[0], 0x20)
        self.assertEqual(self.sdo[0x1018][4].raw, 2)
        self.aborts(ABORT["unknown command"], self.sdo.request_response, bytes([0x10]) + bytes(7))

    def test_an_aborted_transfer_is_over(self) -> None:
        self.assertEqual(self.sdo.request_response(struct.pack("<BHBI", 0x21, STORE, 0, 100))[0], 0x60)
        self.sdo.abort(0x08000000)
        self.aborts(ABORT["unknown command"], self.sdo.request_response, bytes(8))
        self.assertEqual(self.sdo[0x1018][4].raw, 2)

    def keeps(self, size: int, block: bool, crc: bool = True) -> None:
        """Random bytes there and back."""
        data = random.Random(f"{block} {crc}").randbytes(size)
        store = self.sdo[STORE]
        with store.open("wb", size=size, block_transfer=block, request_crc_support=crc, buffering=1024) as out:
            out.write(data)
        with store.open("rb", block_transfer=block, request_crc_support=crc, buffering=1024) as back:
            self.assertEqual(back.read(), data)

    def test_20_kilobytes_by_blocks(self) -> None:
        self.keeps(SIZE, block=True)

    def test_2_kilobytes_by_blocks_without_crc(self) -> None:
        self.keeps(SIZE // 10, block=True, crc=False)

    def test_2_kilobytes_by_segments(self) -> None:
        self.keeps(SIZE // 10, block=False)


if __name__ == "__main__":
    unittest.main(verbosity=2)
