"""Every value of a data sheet, read and written over SDO: what the scripts of slave and master share.

Each readable value is read; each writable one is given another value, which is read back, and then its own again. What
cannot be written so is a method of its own, which says why. `Walk.finish` holds all of it against the data sheet.
"""

from typing import Callable

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable, datatypes
from canopen.sdo import SdoAbortedError, SdoClient

from spacecraft import Test

UNSUPPORTED, WRITE_ONLY, READ_ONLY = 0x06010000, 0x06010001, 0x06010002
INVALID_VALUE, TOO_HIGH, TOO_LOW = 0x06090030, 0x06090031, 0x06090032
INCOMPATIBLE = 0x06040043
NOT_STORED, WRONG_STATE, NO_DATA = 0x08000020, 0x08000022, 0x08000024

#: Bits of COB-IDs: not valid; no remote frames (PDO); a producer (SYNC).
INVALID, NO_REMOTE, PRODUCER = 1 << 31, 1 << 30, 1 << 30
#: An identifier that nobody has.
FREE = 0x1C2
#: Bytes of the types that canopen takes as they are.
LENGTHS = {datatypes.TIME_OF_DAY: 6, datatypes.TIME_DIFFERENCE: 6}
#: Types of any length.
TEXTS = (datatypes.VISIBLE_STRING, datatypes.OCTET_STRING, datatypes.UNICODE_STRING, datatypes.DOMAIN)
#: Sub-indices of a PDO that must not change while it is valid, and an object that every PDO can carry.
INHIBIT, SYNC_START, MAPPABLE = 3, 6, 0x6210_00_20


def variables(dictionary: ObjectDictionary) -> list[ODVariable]:
    """Every value, without the types that stand for dummy entries."""
    entries = [entry for entry in dictionary.values() if entry.index >= 0x1000]
    return [sub for entry in entries for sub in ([entry] if isinstance(entry, ODVariable) else entry.values())]


class Walk:
    """One node, its data sheet, and what was written of it."""

    def __init__(self, test: Test, sdo: SdoClient, dictionary: ObjectDictionary) -> None:
        self._test = test
        self._sdo = sdo
        self._values = {(value.index, value.subindex): value for value in variables(dictionary)}
        self._written: set[tuple[int, int]] = set()

    def refuses(self, code: int, transfer: Callable, *arguments) -> None:
        """The node answers so."""
        with self._test.assertRaises(SdoAbortedError) as refusal:
            transfer(*arguments)
        self._test.assertEqual(f"{refusal.exception.code:08X}h", f"{code:08X}h")

    def read(self, index: int, sub: int = 0) -> bytes:
        """A value as it comes: `SdoClient.upload` would cut it to the length of its type."""
        with self._sdo.open(index, sub, "rb", buffering=0) as stream:
            data = stream.read()
            self._test.assertEqual(stream.size, len(data))
        return data

    def number(self, index: int, sub: int = 0) -> int:
        return int.from_bytes(self.read(index, sub), "little")

    def write(self, index: int, sub: int, value: int | bytes) -> None:
        """A value, a number in the length of its type."""
        self._sdo.download(index, sub, self._bytes(index, sub, value))
        self._written.add((index, sub))

    def refuses_write(self, code: int, index: int, sub: int, value: int | bytes) -> None:
        """The node answers so, and nothing has changed."""
        before = self.read(index, sub) if self._values[index, sub].readable else b""
        self.refuses(code, self._sdo.download, index, sub, self._bytes(index, sub, value))
        if before:
            self._test.assertEqual(self.read(index, sub), before)

    def _bytes(self, index: int, sub: int, value: int | bytes) -> bytes:
        return value if isinstance(value, bytes) else value.to_bytes(self._length(index, sub), "little")

    def _length(self, index: int, sub: int) -> int:
        value = self._values[index, sub]
        return LENGTHS.get(value.data_type, (len(value) + 7) // 8)

    def exchange(self, index: int, sub: int, other: int | bytes | None = None) -> None:
        """Another value and its own again; by default the one that differs in bit 0, if it is within the limits."""
        own = self.read(index, sub)
        limits = self._values[index, sub]
        if other is None and None not in (limits.min, limits.max):
            number = int.from_bytes(own, "little")
            other = next(near for near in (number ^ 1, number - 1, number + 1) if limits.min <= near <= limits.max)
        if other is None:
            # Two bytes: a text of any kind.
            other = bytes([own[0] ^ 1]) + own[1:] if own else b"  "
        for value in (self._bytes(index, sub, other), own):
            self.write(index, sub, value)
            self._test.assertEqual(self.read(index, sub), value)

    def each(self, wanted: Callable[[ODVariable], bool], act: Callable[[int, int], None]) -> None:
        """Does something with each value that is wanted; there must be one."""
        found = [at for at, value in self._values.items() if wanted(value)]
        self._test.assertNotEqual(found, [])
        for index, sub in found:
            with self._test.subTest(index=f"{index:04X}h", sub=sub, name=self._values[index, sub].name):
                act(index, sub)

    def read_all(self, is_unchanged: Callable[[ODVariable], bool]) -> None:
        """What is readable has its type, and the value of the data sheet if it should be unchanged."""
        errors = self.number(0x1003)

        def check(index: int, sub: int) -> None:
            value = self._values[index, sub]
            if index == 0x1003 and sub > errors:
                return self.refuses(NO_DATA, self._sdo.upload, index, sub)
            data = self.read(index, sub)
            if value.data_type not in TEXTS:
                self._test.assertEqual(len(data), self._length(index, sub))
            found = value.decode_raw(data)
            if value.data_type in datatypes.INTEGER_TYPES:
                self._test.assertGreaterEqual(found, found if value.min is None else value.min)
                self._test.assertLessEqual(found, found if value.max is None else value.max)
            if value.data_type in datatypes.NUMBER_TYPES and is_unchanged(value):
                # Zero of a type that some readers do not know is left out of a data sheet.
                self._test.assertEqual(found, value.default or 0)
            if value.data_type == datatypes.VISIBLE_STRING and is_unchanged(value):
                self._test.assertEqual(found, value.default or "")

        def check_refusal(index: int, sub: int) -> None:
            self.refuses(WRITE_ONLY, self._sdo.upload, index, sub)

        self.each(lambda value: value.readable, check)
        self.each(lambda value: not value.readable, check_refusal)

    def refuse_all(self) -> None:
        """What is read-only cannot be written."""

        def check_refusal(index: int, sub: int) -> None:
            self.refuses(READ_ONLY, self._sdo.download, index, sub, self._bytes(index, sub, 0))

        self.each(lambda value: not value.writable, check_refusal)

    def exchange_rest(self) -> None:
        """All that is writable and was not written yet: there is nothing special about it."""
        written = frozenset(self._written)
        self.each(lambda value: value.writable and (value.index, value.subindex) not in written, self.exchange)

    def finish(self) -> None:
        """Nothing that is writable was left out."""
        writable = {at for at, value in self._values.items() if value.writable}
        self._test.assertEqual(writable - self._written, set())

    def errors(self) -> None:
        """1003h: zero forgets the errors, another number means nothing (CiA 301 7.5.2.4)."""
        self.refuses_write(INVALID_VALUE, 0x1003, 0, 1)
        self.write(0x1003, 0, 0)
        self._test.assertEqual(self.number(0x1003), 0)

    def signatures(self, is_stored: bool) -> None:
        """1010h, 1011h: what is written is no value, but a signature."""
        for index, signature in ((0x1010, b"save"), (0x1011, b"load")):
            for sub in range(1, 5):
                own = self.read(index, sub)
                self.refuses_write(NOT_STORED, index, sub, own)
                if is_stored:
                    self.write(index, sub, signature)
                else:
                    self.refuses_write(NOT_STORED, index, sub, signature)
                    self._written.add((index, sub))
                self._test.assertEqual(self.read(index, sub), own)

    def emergency(self) -> None:
        """1014h: while it is valid, its identifier stays (CiA 301 7.5.2.17)."""
        own = self.number(0x1014)
        self.write(0x1014, 0, own & ~INVALID)
        self.refuses_write(INVALID_VALUE, 0x1014, 0, own & ~INVALID ^ 1)
        self.write(0x1014, 0, own)
        self.exchange(0x1014, 0, own ^ INVALID)

    def counter(self) -> None:
        """1019h: only while there is no period; 1 and 241 mean nothing (CiA 301 7.5.2.22)."""
        period = self.number(0x1006)
        self.write(0x1006, 0, 1_000_000)
        self.refuses_write(WRONG_STATE, 0x1019, 0, 10)
        self.write(0x1006, 0, 0)
        for reserved in (1, 241):
            self.refuses_write(INVALID_VALUE, 0x1019, 0, reserved)
        self.exchange(0x1019, 0, 10)
        self.write(0x1006, 0, period)

    def identity(self) -> None:
        """2046h: a Node-ID is stored in maintenance mode only (ECSS 6.10g)."""
        for node in (0, 3, 5):
            self.refuses_write(WRONG_STATE, 0x2046, 1, bytes([node, 0xFF - node, 0x49, 0x44]))
        self._written.add((0x2046, 1))

    def self_test(self) -> None:
        """2030h: 1 begins it, and nothing else."""
        self.refuses_write(TOO_LOW, 0x2030, 0, 0)
        self.refuses_write(TOO_HIGH, 0x2030, 0, 2)
        self.write(0x2030, 0, 1)

    def pdo(self, parameters: int, mapping: int, mappable: int = MAPPABLE) -> None:
        """A PDO is made invalid, then changed, then made valid (CiA 301 7.5.2.35 to 7.5.2.38)."""
        subs = [sub for index, sub in self._values if index == parameters and sub > 1]
        objects = range(1, 9)
        own, count = self.number(parameters, 1), self.number(mapping, 0)
        mapped = [self.number(mapping, sub) for sub in objects]
        if not own & INVALID:
            self.refuses_write(UNSUPPORTED, parameters, 1, own ^ 0x20)
            for sub in {INHIBIT, SYNC_START}.intersection(subs):
                self.refuses_write(UNSUPPORTED, parameters, sub, self.number(parameters, sub))
            for sub, value in enumerate([count, *mapped]):
                self.refuses_write(UNSUPPORTED, mapping, sub, value)
            self.write(parameters, 1, own | INVALID)
        for sub in subs:
            self.exchange(parameters, sub)
        if count:
            for sub in objects:
                self.refuses_write(UNSUPPORTED, mapping, sub, mapped[sub - 1])
        self.write(mapping, 0, 0)
        self.refuses_write(INCOMPATIBLE, parameters, 1, NO_REMOTE | (own & 0x7FF or FREE))
        for sub in objects:
            self.exchange(mapping, sub, mappable)
        self.write(mapping, 1, mappable)
        self.exchange(mapping, 0, 1)
        # What SYNC has is no PDO's.
        self.write(mapping, 0, 1)
        self.refuses_write(INCOMPATIBLE, parameters, 1, NO_REMOTE | self.number(0x1005) & 0x7FF)
        self.write(mapping, 0, 0)
        self.write(mapping, 1, mapped[0])
        self.write(mapping, 0, count)
        self.exchange(parameters, 1, own ^ 1 | INVALID)
        self.write(parameters, 1, own)
        self._test.assertEqual(self.number(parameters, 1), own)
        self._test.assertEqual([self.number(mapping, sub) for sub in range(9)], [count, *mapped])
