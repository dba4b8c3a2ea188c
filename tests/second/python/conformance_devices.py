"""The slaves that the conformance cases are run with: what the cases have to know of each, and which cases do not apply to it.

Both have 6400h with values of each type that a case uses, and 6300h, a block of bytes.
"""

import os
from typing import NamedTuple

#: Node-ID of the slave.
NODE = 3


class Device(NamedTuple):
    """A slave."""

    #: Cases that apply to it.
    cases: int
    #: Cases that do not, with the reason.
    not_applicable: dict[str, str]
    #: Parameters of an RPDO and of a TPDO that are not valid at power-on.
    rpdo: int
    tpdo: int
    #: An object that is write-only, and its sub-index.
    write_only: tuple[int, int]
    #: An RPDO that is valid at power-on, and data that are too short for it.
    command: int
    short: bytes
    #: Length of TPDO 1 in bytes, and whether SYNC sends it at power-on.
    telemetry: int
    is_synchronous: bool
    #: Without heartbeats of its master it changes the bus, and ignores the fourth reset in a row.
    needs_master: bool


DEVICES = {
    # A slave on two buses: `firmware/fixtures`.
    "test-device": Device(
        cases=221,
        not_applicable={},
        rpdo=0x1404,
        tpdo=0x1804,
        write_only=(0x2030, 0),
        command=0x300 + NODE,
        short=bytes(3),
        telemetry=7,
        is_synchronous=True,
        needs_master=True,
    ),
    # A slave on one bus, by async-canopen alone: `firmware/examples/embassy-slave`.
    "heater": Device(
        cases=219,
        not_applicable={
            "SDO: 08000020h, not the signature of 1010h": "it has no parameter store",
            "SDO: 08000020h, not the signature of 1011h": "it has no parameter store",
        },
        rpdo=0x1401,
        tpdo=0x1801,
        write_only=(0x6400, 29),
        command=0x200 + NODE,
        short=b"",
        telemetry=2,
        is_synchronous=False,
        needs_master=False,
    ),
}

DEVICE = DEVICES[os.environ.get("DEVICE", "test-device")]
