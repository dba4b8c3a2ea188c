"""Emergencies and heartbeats of a slave that the canopen package plays: node 9, next to the emulated master and slaves 2, 3.

What the master hears of emergencies is in its log only, which the test looks at.
"""

import unittest

from canopen import LocalNode
from canopen.objectdictionary import ObjectDictionary, ODVariable, datatypes

from spacecraft import BOOT_UP, MASTER_EDS, OPERATIONAL, Test, Observer

NODE = 9
#: Milliseconds.
PERIOD, CONSUMER = 50, 1000
STATE, CONSUMERS, EMCY, REGISTER, HISTORY = 0x1F82, 0x1016, 0x1014, 0x1001, 0x1003
#: Of the nominal bus: frames that are not what their COB-ID says.
HEALTH, MALFORMED = 0x2020, 8
MISSING = 1
#: The answer of a slave to the master's question for its device type (1000h).
IDENTIFIED = bytes.fromhex("43 00 10 00")
NO_ERROR, HEARTBEAT = 0x0000, 0x8130
#: Bits of the error register: generic, communication.
COMMUNICATION = 0x11


def dictionary() -> ObjectDictionary:
    """A node with a heartbeat."""
    found = ObjectDictionary()
    period = ODVariable("Producer heartbeat time", 0x1017)
    period.data_type, period.access_type, period.default = datatypes.UNSIGNED16, "rw", PERIOD
    found.add_object(period)
    return found


class Emergencies(Test):
    def setUp(self) -> None:
        self.net = self.connect()
        (self.slave,) = self.nodes(self.net, 2)
        self.master = self.net.add_node(1, str(MASTER_EDS))
        self.master.sdo.RESPONSE_TIMEOUT = self.slave.remote.sdo.RESPONSE_TIMEOUT
        self.is_identified()
        # On a channel of its own, so that the others hear it.
        self.local = LocalNode(NODE, dictionary())
        self.connect().add_node(self.local)
        self.addCleanup(self.local.nmt.stop_heartbeat)

    def is_identified(self) -> None:
        """Resets slave 2 and waits until the master has identified it.

        The master and this client share the default SDO of the slave: a request of one ends the transfer of the other.
        """
        answers = Observer()
        self.net.subscribe(0x702, lambda _id, data, _at: answers(bytes(data)))
        self.net.subscribe(0x582, lambda _id, data, _at: answers(bytes(data)[:4]))
        self.slave.becomes(OPERATIONAL)
        answers.forget()
        self.slave.remote.nmt.state = "RESET"
        answers.wait_for(
            lambda heard: bytes([BOOT_UP]) in heard and IDENTIFIED in heard[heard.index(bytes([BOOT_UP])) :]
        )
        self.slave.becomes(OPERATIONAL)

    def appears(self) -> None:
        """It boots up, waits in Pre-operational, and is started by the master."""
        self.local.nmt.state = "INITIALISING"
        self.local.nmt.state = "PRE-OPERATIONAL"
        self.until(lambda: self.local.nmt.state == "OPERATIONAL")
        self.reads(OPERATIONAL)

    def reads(self, state: int) -> None:
        """Asks the master until that is the state of the node."""
        self.until(lambda: self.master.sdo[STATE][NODE].raw == state)

    def test_its_emergencies_are_heard(self) -> None:
        self.appears()
        malformed = self.master.sdo[HEALTH][MALFORMED]
        before = malformed.raw
        for code, register, data in [
            (0x5530, 0x81, b"flash"),
            (0x4210, 0x09, b"\x00\x01\x7f\x80\xff"),
            (0xFF01, 0x01, b""),
        ]:
            self.local.emcy.send(code, register, data)
        self.local.emcy.reset()
        # CiA 301 7.2.7.2: 8 bytes. One byte less is none.
        self.net.send_message(0x80 + NODE, bytes.fromhex("30558166 6C6173"))
        self.until(lambda: malformed.raw == before + 1)

    def test_the_master_sees_its_heartbeat_come_and_go(self) -> None:
        self.appears()
        self.local.nmt.stop_heartbeat()
        self.reads(MISSING)
        self.appears()

    def consumes(self, consumer, subindex: int) -> None:
        """1016h: it tells when the node is missed, and when it is back."""
        consumer.sdo[CONSUMERS][subindex].raw = NODE << 16 | CONSUMER
        errors = Observer()
        consumer.emcy.add_callback(lambda error: errors((error.code, error.register, error.data.rstrip(b"\0"))))
        self.appears()
        self.local.nmt.stop_heartbeat()
        errors.wait_for(lambda told: (HEARTBEAT, COMMUNICATION, bytes([NODE])) in told)
        self.assertEqual(consumer.sdo[REGISTER].raw, COMMUNICATION)
        self.assertEqual(consumer.sdo[HISTORY][1].raw & 0xFFFF, HEARTBEAT)
        errors.forget()
        self.appears()
        errors.wait_for(lambda told: (NO_ERROR, 0, bytes.fromhex("3081 09")) in told)
        self.assertEqual(consumer.sdo[REGISTER].raw, 0)
        consumer.sdo[CONSUMERS][subindex].raw = 0

    def test_the_master_is_a_consumer_of_its_heartbeat(self) -> None:
        """1014h of the master is valid at power-on, as that of a slave."""
        self.assertEqual(self.master.sdo[EMCY].raw, 0x81)
        self.consumes(self.master, 8)

    def test_a_slave_is_a_consumer_of_its_heartbeat(self) -> None:
        self.consumes(self.slave.remote, 2)


if __name__ == "__main__":
    unittest.main(verbosity=2)
