"""Every object of slaves 2 and 3 over SDO, by the canopen package and the data sheet; master is this script."""

import random
import struct
import unittest

import canopen
from canopen.objectdictionary import ODVariable, datatypes
from canopen.sdo import SdoAbortedError

from spacecraft import EDS, Test

ERROR_HISTORY = 0x1003
STORE = 0x6300
#: What a data store holds at least.
SIZE = 20_000

ABORT = {
    "unknown command": 0x05040001,
    "write only": 0x06010001,
    "read only": 0x06010002,
    "no object": 0x06020000,
    "too long": 0x06070012,
    "too short": 0x06070013,
    "no sub-index": 0x06090011,
    "too large a value": 0x06090031,
    "too small a value": 0x06090032,
    "no data": 0x08000024,
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
}


def variables(dictionary: canopen.ObjectDictionary) -> list[ODVariable]:
    """Every value of the data sheet."""
    entries = [entry for entry in dictionary.values() if entry.index >= 0x1000]
    return [sub for entry in entries for sub in ([entry] if isinstance(entry, ODVariable) else entry.values())]


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

    def test_every_readable_object_is_read(self) -> None:
        errors = self.sdo[ERROR_HISTORY][0].raw
        for value in variables(canopen.import_od(str(EDS), 2)):
            with self.subTest(index=f"{value.index:04X}h", sub=value.subindex, name=value.name):
                if value.data_type == datatypes.DOMAIN:
                    continue
                if not value.readable:
                    self.aborts(ABORT["write only"], self.sdo.upload, value.index, value.subindex)
                    continue
                if value.index == ERROR_HISTORY and value.subindex > errors:
                    self.aborts(ABORT["no data"], self.sdo.upload, value.index, value.subindex)
                    continue
                raw = self.sdo.upload(value.index, value.subindex)
                if value.data_type in datatypes.NUMBER_TYPES:
                    self.assertEqual(len(raw), (len(value) + 7) // 8)
                if value.access_type == "const":
                    self.assertEqual(value.decode_raw(raw), value.default)

    def test_what_is_read_only_cannot_be_written(self) -> None:
        for value in variables(canopen.import_od(str(EDS), 2)):
            if not value.writable:
                with self.subTest(index=f"{value.index:04X}h", sub=value.subindex, name=value.name):
                    size = max(1, (len(value) + 7) // 8)
                    self.aborts(ABORT["read only"], self.sdo.download, value.index, value.subindex, bytes(size))

    def test_values_of_every_type_are_kept(self) -> None:
        """Expedited up to 4 bytes, segmented above."""
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
