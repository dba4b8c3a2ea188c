"""A bus, a slave on it, and the cases that are tried with it."""

import contextlib
import struct
import time
from typing import Callable, Iterator, NamedTuple

import can

from conformance_devices import DEVICE, NODE
from spacecraft import NOMINAL, OPERATIONAL, PATIENCE

NMT, SYNC, MASTER = 0x000, 0x080, 0x701
EMCY, REQUEST, RESPONSE, HEARTBEAT = 0x080 + NODE, 0x600 + NODE, 0x580 + NODE, 0x700 + NODE

START, STOP, PREPARE, RESET_NODE, RESET_COMMUNICATION = 0x01, 0x02, 0x80, 0x81, 0x82

#: Abort codes (CiA 301 Table 22).
TOGGLE, TIMEOUT, UNKNOWN_COMMAND = 0x05030000, 0x05040000, 0x05040001
BLOCK_SIZE, SEQUENCE, CRC, MEMORY = 0x05040002, 0x05040003, 0x05040004, 0x05040005
UNSUPPORTED, WRITE_ONLY, READ_ONLY, NO_OBJECT = 0x06010000, 0x06010001, 0x06010002, 0x06020000
NOT_MAPPABLE, PDO_LENGTH, INCOMPATIBLE = 0x06040041, 0x06040042, 0x06040043
TOO_LONG, TOO_SHORT, NO_SUB = 0x06070012, 0x06070013, 0x06090011
RANGE, TOO_HIGH, TOO_LOW = 0x06090030, 0x06090031, 0x06090032
NOT_STORED, WRONG_STATE, NO_DATA = 0x08000020, 0x08000022, 0x08000024

#: What has not come after so many seconds does not come: a frame takes some milliseconds.
SOON = 0.3

Falsify = Callable[[can.Message], can.Message]


class Case(NamedTuple):
    """Something that the slave must do."""

    name: str
    run: Callable[["Bench"], None]


#: All of them, in the order in which they are tried.
CASES: list[Case] = []
#: How a server breaks the rule of a case: what it sends instead.
FALSIFIED: dict[str, Falsify] = {}


def case(name: str, broken: Falsify | None = None) -> Callable[[Callable[["Bench"], None]], Callable[["Bench"], None]]:
    """A function that is a case; `broken`: how a server that does not keep its rule would answer."""

    def add(run: Callable[["Bench"], None]) -> Callable[["Bench"], None]:
        assert name not in {case.name for case in CASES}, f"{name} is there already"
        CASES.append(Case(name, run))
        if broken:
            FALSIFIED[name] = broken
        return run

    return add


def byte(number: int, value: int, identifier: int = RESPONSE) -> Falsify:
    """A server whose frames have another byte there."""

    def falsify(message: can.Message) -> can.Message:
        if message.arbitration_id == identifier and len(message.data) > number:
            message.data[number] = value
        return message

    return falsify


def abort(index: int, sub: int, code: int) -> bytes:
    """What an SDO server answers that refuses."""
    return struct.pack("<BHBI", 0x80, index, sub, code)


class Bench:
    """The slave's bus, and this script on it."""

    def __init__(self) -> None:
        self._bus = can.Bus(interface="slcan", channel=NOMINAL, bitrate=1_000_000, sleep_after_open=0)
        self._master = None
        if DEVICE.needs_master:
            self._master = self._bus.send_periodic(self._message(MASTER, [OPERATIONAL]), 0.25)
        self._falsify: Falsify | None = None
        self.wait_for(HEARTBEAT)

    def close(self) -> None:
        if self._master:
            self._master.stop()
        self._bus.shutdown()

    @contextlib.contextmanager
    def falsified(self, falsify: Falsify) -> Iterator[None]:
        """What the slave sends comes as this makes it."""
        self._falsify = falsify
        try:
            yield
        finally:
            self._falsify = None

    @staticmethod
    def _message(identifier: int, data: list[int] | bytes) -> can.Message:
        return can.Message(arbitration_id=identifier, data=data, is_extended_id=False)

    def prepare(self) -> None:
        """As each case finds it: Pre-operational, no transfer, the communication profile as after power-on, no error."""
        self.reset(RESET_COMMUNICATION)
        # Ends an error of the length of SYNC. Others end with the program.
        self.send(SYNC)
        if self.read(0x1001) != 0:
            self.reset(RESET_NODE)
        self.write(0x1015, 0, 0, 2)
        # The end of an error that waited for its inhibit time comes before this answer.
        self.is_there()
        self.forget()

    def reset(self, command: int) -> None:
        """A reset, until the slave is Pre-operational and answers."""
        self.forget()
        if DEVICE.needs_master:
            # The fourth reset in a row without a heartbeat of the master is ignored, as forged.
            self.send(MASTER, [OPERATIONAL])
        self.nmt(command)
        self.wait_for(HEARTBEAT, bytes([0]))
        self.nmt(PREPARE)
        self.is_there()
        self.forget()

    def nmt(self, command: int, node: int = NODE) -> None:
        self.send(NMT, [command, node])

    def send(self, identifier: int, data: list[int] | bytes | str = b"") -> None:
        """A frame; a text is hexadecimal."""
        payload = bytes.fromhex(data) if isinstance(data, str) else data
        self._bus.send(self._message(identifier, payload))

    def forget(self) -> None:
        """All that has come."""
        while self._bus.recv(0):
            pass

    def frames(self, seconds: float) -> Iterator[can.Message]:
        """Frames of others as they come, for so long on the clock."""
        end = time.monotonic() + seconds
        while (rest := end - time.monotonic()) > 0:
            message = self._bus.recv(rest)
            if message:
                yield self._falsify(message) if self._falsify else message

    def wait_for(self, identifier: int, data: bytes | None = None) -> bytes:
        """The next frame of this identifier, or the next with these data."""
        seconds = SOON * 10 if self._falsify else PATIENCE
        for message in self.frames(seconds):
            if message.arbitration_id == identifier and data in (None, bytes(message.data)):
                return bytes(message.data)
        raise AssertionError(f"{identifier:03X}h {'' if data is None else data.hex(' ')} does not come")

    def hears(self, identifier: int, data: list[int] | bytes | str) -> None:
        """The next frame of this identifier has these data."""
        expected = bytes.fromhex(data) if isinstance(data, str) else bytes(data)
        came = self.wait_for(identifier)
        assert came == expected, f"{identifier:03X}h: {came.hex(' ')} instead of {expected.hex(' ')}"

    def hears_end(self, code: int) -> None:
        """The next emergency says that this error is over, and that there is no other one."""
        came = self.wait_for(EMCY)
        assert came[:5] == struct.pack("<HBH", 0, 0, code), f"{came.hex(' ')} is not the end of {code:04X}h"

    def hears_nothing(self, *identifiers: int, seconds: float = SOON) -> None:
        """No frame of these identifiers comes."""
        for message in self.frames(seconds):
            assert message.arbitration_id not in identifiers, f"nobody asked for {message}"

    def exchange(self, *pairs: tuple[str, str]) -> None:
        """SDO requests and their responses, hexadecimal; zeros at the end may be left out. No response: an empty text."""
        for request, response in pairs:
            self.send(REQUEST, bytes.fromhex(request).ljust(8, b"\0"))
            if response:
                self.hears(RESPONSE, bytes.fromhex(response).ljust(8, b"\0"))

    def refuses(self, request: str, index: int, sub: int, code: int) -> None:
        """An SDO request is answered by an abort."""
        self.send(REQUEST, bytes.fromhex(request).ljust(8, b"\0"))
        self.hears(RESPONSE, abort(index, sub, code))

    def write(self, index: int, sub: int, value: int, length: int) -> None:
        """A value of at most four bytes."""
        self.send(REQUEST, self.download(index, sub, value, length))
        self.hears(RESPONSE, struct.pack("<BHBI", 0x60, index, sub, 0))

    def refuses_write(self, index: int, sub: int, value: int, length: int, code: int) -> None:
        self.send(REQUEST, self.download(index, sub, value, length))
        self.hears(RESPONSE, abort(index, sub, code))

    @staticmethod
    def download(index: int, sub: int, value: int, length: int) -> bytes:
        """The request that writes a value of at most four bytes."""
        command = 0x23 | (4 - length) << 2
        return struct.pack("<BHBI", command, index, sub, value)

    def read(self, index: int, sub: int = 0) -> int:
        """A value of at most four bytes."""
        self.send(REQUEST, struct.pack("<BHBI", 0x40, index, sub, 0))
        command, found, at, value = struct.unpack("<BHBI", self.wait_for(RESPONSE))
        assert (found, at) == (index, sub), f"{found:04X}h sub {at} instead of {index:04X}h sub {sub}"
        assert command & 0xF3 == 0x43, f"{index:04X}h sub {sub}: {command:02X}h, {value:08X}h"
        return value & (1 << 8 * (4 - (command >> 2 & 3))) - 1

    def synchronize(self) -> None:
        """From now on TPDO 1 goes out with every SYNC."""
        if not DEVICE.is_synchronous:
            self.write(0x1800, 2, 1, 1)

    def is_there(self) -> None:
        """It answers, and has nothing else to say before."""
        self.send(REQUEST, "40 18 10 04 00 00 00 00")
        self.hears(RESPONSE, "43 18 10 04 03 00 00 00")

    def state(self) -> int:
        """Of its next heartbeat."""
        self.forget()
        return self.wait_for(HEARTBEAT)[0]
