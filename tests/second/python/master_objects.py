"""Every object of the emulated master over SDO, by the canopen package and its EDS, while it commands slaves 2 to 4."""

import unittest

import canopen

from objects import FREE, INVALID, INVALID_VALUE, PRODUCER, Walk
from spacecraft import MASTER_EDS, OPERATIONAL, PATIENCE, PRE_OPERATIONAL, Test

SLAVES = (2, 3, 4)
EMERGENCIES, STARTUP, ASSIGNMENT, REQUEST = 0x1028, 0x1F80, 0x1F81, 0x1F82
#: Bit 3 of an assignment: SYNC waits for the slave, which means nothing where there is none.
MANDATORY = 1 << 3
#: Request: node 0.
ALL = 128
#: PDOs: one way a time and a telemetry of each slave, the other the time.
RPDOS, TPDOS = 28, 1
#: What mappings may have: 16 bits without an object, and the error register.
GAP, ERROR_REGISTER = 0x0006_0010, 0x1001_0008


class MasterObjects(Test):
    def test_every_object_is_read_and_written(self) -> None:
        net = self.connect()
        slaves = self.nodes(net, *SLAVES)
        for slave in slaves:
            slave.becomes(OPERATIONAL)
        dictionary = canopen.import_od(str(MASTER_EDS), 1)
        master = net.add_node(1, dictionary)
        master.sdo.RESPONSE_TIMEOUT = PATIENCE
        walk = Walk(self, master.sdo, dictionary)

        walk.read_all(is_unchanged=lambda value: value.access_type in ("const", "rw") and value.index != REQUEST)
        walk.refuse_all()

        walk.errors()
        walk.signatures(is_stored=True)
        walk.emergency()
        walk.counter()
        walk.self_test()
        walk.identity()
        # Its identifier stays while it produces SYNC (CiA 301 7.5.2.5).
        walk.refuses_write(INVALID_VALUE, 0x1005, 0, walk.number(0x1005) ^ 1)
        walk.exchange(0x1005, 0, walk.number(0x1005) ^ PRODUCER)
        # A master has nothing to choose there.
        walk.refuses_write(INVALID_VALUE, STARTUP, 0, walk.number(STARTUP) ^ 1 << 2)
        walk.exchange(STARTUP, 0, walk.number(STARTUP))
        for node in range(1, 128):
            walk.exchange(ASSIGNMENT, node, walk.number(ASSIGNMENT, node) ^ MANDATORY)
        # Emergencies of a node have its COB-ID, or are not consumed; the master does not consume its own.
        walk.refuses_write(INVALID_VALUE, EMERGENCIES, 1, 0x81)
        for node in range(1, 128):
            walk.refuses_write(INVALID_VALUE, EMERGENCIES, node, FREE)
            walk.exchange(EMERGENCIES, node, INVALID)
        # What is read there is a state, what is written a command: slaves that run are started, others are not there.
        for node in range(1, ALL + 1):
            state = walk.number(REQUEST, node)
            self.assertEqual(state, OPERATIONAL if node in (1, *SLAVES) else 0, node)
            walk.refuses_write(INVALID_VALUE, REQUEST, node, 0)
            walk.write(REQUEST, node, OPERATIONAL)
            self.assertEqual(walk.number(REQUEST, node), state, node)
        # Its PDOs stop, so that no telemetry comes between a write and its check.
        walk.write(REQUEST, 1, PRE_OPERATIONAL)
        for first, count, mappable in ((0x1400, RPDOS, GAP), (0x1800, TPDOS, ERROR_REGISTER)):
            for parameters in range(first, first + count):
                with self.subTest(pdo=f"{parameters:04X}h"):
                    walk.pdo(parameters, parameters + 0x200, mappable)
        walk.exchange_rest()
        walk.write(REQUEST, 1, OPERATIONAL)
        walk.finish()
        for slave in slaves:
            slave.becomes(OPERATIONAL, times=2)


if __name__ == "__main__":
    unittest.main(verbosity=2)
