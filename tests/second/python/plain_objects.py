"""Every object of slave 3, a CANopen slave on one bus, over SDO, by the canopen package and its DCF: `firmware/examples/embassy-slave`."""

import unittest

import canopen

from objects import INVALID_VALUE, PRODUCER, TOO_LOW, Walk
from spacecraft import DCF, PRE_OPERATIONAL, Test

#: UNSIGNED32, which every PDO can carry.
MAPPABLE = 0x6400_07_20


class PlainObjects(Test):
    def test_every_object_is_read_and_written(self) -> None:
        net = self.connect()
        (slave,) = self.nodes(net, 3)
        slave.remote.nmt.state = "PRE-OPERATIONAL"
        slave.becomes(PRE_OPERATIONAL)
        walk = Walk(self, slave.remote.sdo, canopen.import_od(str(DCF)))

        walk.read_all(is_unchanged=lambda value: value.access_type in ("const", "rw", "rww"))
        walk.refuse_all()

        walk.errors()
        walk.emergency()
        walk.counter()
        # A slave produces no SYNC.
        walk.refuses_write(INVALID_VALUE, 0x1005, 0, walk.number(0x1005) | PRODUCER)
        # A microsecond is none.
        walk.refuses_write(TOO_LOW, 0x1006, 0, 1)
        walk.exchange(0x1006, 0, 1_000_000)
        # Bit 2 is the one that a slave obeys.
        walk.refuses_write(INVALID_VALUE, 0x1F80, 0, walk.number(0x1F80) ^ 1)
        walk.exchange(0x1F80, 0, walk.number(0x1F80) ^ 1 << 2)
        walk.write(0x6400, 29, 1)
        for parameters in (0x1400, 0x1401, 0x1800, 0x1801):
            with self.subTest(pdo=f"{parameters:04X}h"):
                walk.pdo(parameters, parameters + 0x200, MAPPABLE)
        walk.exchange_rest()
        walk.finish()


if __name__ == "__main__":
    unittest.main(verbosity=2)
