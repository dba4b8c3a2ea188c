"""The emulated master and slaves 2 and 3, test devices, leave a bus in the middle of an SDO transfer, by the canopen package on both.

Other nodes are played by the package. When they fall silent the master misses half of its slaves and goes to the other bus;
soon afterwards back again only for more of them than before.
"""

import random
import struct
import unittest

from canopen import LocalNode
from canopen.objectdictionary import ObjectDictionary
from canopen.sdo import SdoAbortedError, SdoCommunicationError

from spacecraft import EDS, MASTER_EDS, NOMINAL, OPERATIONAL, PATIENCE, REDUNDANT, Test, Observer

FOREIGN = (10, 11, 12, 13)
#: Milliseconds; the master of this profile is patient for 2.5 s.
PERIOD = 250
STORE, NUMBER, STATES = 0x6300, (0x6400, 0x07), 0x1F82
#: Command specifiers, and the size of what is moved.
DOWNLOAD, DOWNLOAD_SEGMENT, UPLOAD, UPLOAD_SEGMENT, LONG = 0x21, 0x00, 0x40, 0x60, 3500
#: Seconds after which there is no answer any more.
GONE = 3.0
UNKNOWN_COMMAND, NO_OBJECT, DEVICE_STATE = 0x05040001, 0x06020000, 0x08000022


class Side:
    """One bus: slave 2, the master, and the nodes that are played."""

    def __init__(self, test: Test, url: str) -> None:
        net = test.connect(url)
        self.master_heard = Observer()
        net.subscribe(0x701, lambda _id, data, _at: self.master_heard(bytes(data)))
        self.responses = Observer()
        net.subscribe(0x582, lambda _id, data, _at: self.responses(bytes(data)))
        self.slave = net.add_node(2, str(EDS))
        self.slave.sdo.RESPONSE_TIMEOUT = PATIENCE
        self.master = net.add_node(1, str(MASTER_EDS))
        # On a channel of their own, so that the others hear them.
        channel = test.connect(url)
        self.foreign = [LocalNode(number, ObjectDictionary()) for number in FOREIGN]
        for node in self.foreign:
            channel.add_node(node)
            test.addCleanup(node.nmt.stop_heartbeat)


class Failover(Test):
    def setUp(self) -> None:
        self.nominal, self.redundant = Side(self, NOMINAL), Side(self, REDUNDANT)
        self.nominal.master_heard.wait_for(bool)
        self.until(lambda: self.is_operational(self.nominal, 2, 3))

    def is_operational(self, side: Side, *numbers: int) -> bool:
        """As the master sees it."""
        try:
            return all(side.master.sdo[STATES][number].raw == OPERATIONAL for number in numbers)
        except SdoCommunicationError:
            return False

    def serves(self, side: Side) -> None:
        """Expedited, by segments, by blocks, and not what cannot be."""
        sdo = side.slave.sdo
        value = random.Random(side is self.nominal).randbytes(4)
        sdo.download(*NUMBER, value)
        self.assertEqual(sdo.upload(*NUMBER), value)
        self.keeps(side, 100, block=False)
        self.keeps(side, 500)
        with self.assertRaises(SdoAbortedError) as refusal:
            sdo.upload(0x5FFF, 0)
        self.assertEqual(refusal.exception.code, NO_OBJECT)

    def keeps(self, side: Side, size: int, block: bool = True) -> None:
        """Random bytes there and back."""
        data = random.Random(size).randbytes(size)
        with side.slave.sdo.open(STORE, 0, "wb", size=size, block_transfer=block, buffering=1024) as out:
            out.write(data)
        with side.slave.sdo.open(STORE, 0, "rb", block_transfer=block, buffering=1024) as back:
            self.assertEqual(back.read(), data)

    def moves(self, here: Side, there: Side, count: int, initiate: int, segment: int) -> None:
        """So many foreign nodes go to the other bus, and the spacecraft with them.

        There is always a transfer of these requests until then: it ends with silence here, and with an abort there.
        """
        self.play(here, count)
        there.master_heard.forget()
        there.responses.forget()
        for node in here.foreign:
            node.nmt.stop_heartbeat()
        sdo = here.slave.sdo
        sdo.MAX_RETRIES, sdo.RESPONSE_TIMEOUT = 1, GONE
        with self.assertRaises(SdoCommunicationError):
            while True:
                sdo.request_response(struct.pack("<BHBI", initiate, STORE, 0, LONG))
                for number in range(LONG // 7 - 1):
                    sdo.request_response(bytes([segment | 0x10 * (number % 2)]) + bytes(7))
        sdo.RESPONSE_TIMEOUT = PATIENCE
        there.master_heard.wait_for(bool)
        abort = struct.pack("<BHBI", 0x80, STORE, 0, DEVICE_STATE)
        there.responses.wait_for(lambda told: abort in told)
        self.play(there, count)
        self.until(lambda: self.is_operational(there, 2, 3))

    def play(self, side: Side, count: int) -> None:
        """So many foreign nodes have heartbeats, and the master has heard them."""
        played = side.foreign[:count]
        for node in played:
            node.nmt.state = "OPERATIONAL"
            node.nmt.start_heartbeat(PERIOD)
        self.until(lambda: self.is_operational(side, *(node.id for node in played)))

    def test_there_and_back(self) -> None:
        nominal, redundant = self.nominal, self.redundant
        self.serves(nominal)
        kept = nominal.slave.sdo.upload(*NUMBER)

        self.moves(nominal, redundant, 2, DOWNLOAD, DOWNLOAD_SEGMENT)
        self.assertEqual(redundant.slave.sdo.upload(*NUMBER), kept)
        with self.assertRaises(SdoAbortedError) as refusal:
            redundant.slave.sdo.request_response(bytes(8))
        self.assertEqual(refusal.exception.code, UNKNOWN_COMMAND, "the transfer is over")
        self.serves(redundant)

        self.keeps(redundant, LONG)
        self.moves(redundant, nominal, 4, UPLOAD, UPLOAD_SEGMENT)
        self.serves(nominal)


if __name__ == "__main__":
    unittest.main(verbosity=2)
