"""An SDO server of the durand package, which knows blocks: node 5 of the nominal bus, until its standard input ends.

It says when it is there, and then what is written to it: index, sub-index, bytes.
"""

import sys

import can
from durand import CANBusNetwork, MinimalNode, Variable
from durand.datatypes import DatatypeEnum

from spacecraft import NOMINAL

NODE = 5
DOMAIN, CONSTANT, KEY = 0x2008, 0x2009, 0x200B


def pattern(size: int) -> bytes:
    """Bytes that differ from their neighbours; the test knows them, too."""
    return bytes(at * 167 % 251 for at in range(size))


def tell(value: bytes) -> None:
    """What was written."""
    print(f"{DOMAIN:04X} 00 {value.hex()}", flush=True)


if __name__ == "__main__":
    with can.Bus(interface="slcan", channel=NOMINAL, bitrate=1_000_000, sleep_after_open=0) as bus:
        network = CANBusNetwork(bus)
        node = MinimalNode(network, NODE)
        objects = node.object_dictionary
        for index, access in ((DOMAIN, "rw"), (CONSTANT, "ro"), (KEY, "wo")):
            objects[index] = Variable(DatatypeEnum.DOMAIN, access, pattern(1000))
        objects.download_callbacks[DOMAIN, 0].add(tell)
        print("serving", flush=True)
        sys.stdin.read()
        network.stop()
