"""Every object of slave 3 over SDO, by the canopen package and its DCF; master is this script."""

import unittest

import canopen

from objects import INVALID_VALUE, PRODUCER, TOO_LOW, Walk
from spacecraft import DCF, PRE_OPERATIONAL, Test


class SlaveObjects(Test):
    def test_every_object_is_read_and_written(self) -> None:
        net = self.connect(is_master=True)
        (slave,) = self.nodes(net, 3)
        slave.remote.nmt.state = "PRE-OPERATIONAL"
        slave.becomes(PRE_OPERATIONAL)
        walk = Walk(self, slave.remote.sdo, canopen.import_od(str(DCF)))

        # What only others write has its default still.
        walk.read_all(is_unchanged=lambda value: value.access_type in ("const", "rw", "rww"))
        walk.refuse_all()

        walk.errors()
        walk.signatures(is_stored=True)
        walk.emergency()
        walk.counter()
        walk.self_test()
        walk.identity()
        # Only the master produces SYNC (ECSS 6.9d).
        walk.refuses_write(INVALID_VALUE, 0x1005, 0, walk.number(0x1005) | PRODUCER)
        # A microsecond is none.
        walk.refuses_write(TOO_LOW, 0x1006, 0, 1)
        walk.exchange(0x1006, 0, 1_000_000)
        # Bit 2 is the one that a slave obeys.
        walk.refuses_write(INVALID_VALUE, 0x1F80, 0, walk.number(0x1F80) ^ 1)
        walk.exchange(0x1F80, 0, walk.number(0x1F80) ^ 1 << 2)
        for first in (0x1400, 0x1800):
            for parameters in range(first, first + 8):
                with self.subTest(pdo=f"{parameters:04X}h"):
                    walk.pdo(parameters, parameters + 0x200)
        walk.exchange_rest()
        walk.finish()


if __name__ == "__main__":
    unittest.main(verbosity=2)
