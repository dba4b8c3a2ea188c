"""CiA 301, rule by rule, by frames alone: slave 3, a test device, whose master is this script (python-can).

A case sends frames and says which ones answer; a rule that is not kept makes it fail. Ten of them are seen to fail against a
server that breaks their rule: what the slave sends is falsified on its way. The number of cases is printed.
"""

import faulthandler
import random
import unittest

# Each has cases.
import conformance_nmt
import conformance_objects
import conformance_pdo
import conformance_sdo

from conformance_bench import CASES, FALSIFIED, Bench

# There are many cases.
faulthandler.dump_traceback_later(900, exit=True)

#: Fewer mean that some are not found any more.
LEAST = 150


class Conformance(unittest.TestCase):
    def setUp(self) -> None:
        self.bench = Bench()
        self.addCleanup(self.bench.close)

    def test_1_every_case(self) -> None:
        self.assertGreaterEqual(len(CASES), LEAST)
        for case in CASES:
            with self.subTest(case=case.name):
                self.bench.prepare()
                case.run(self.bench)
        print(f"{len(CASES)} cases")

    def test_2_ten_cases_fail_where_their_rule_is_broken(self) -> None:
        chosen = random.Random(301).sample(sorted(FALSIFIED), 10)
        cases = {case.name: case for case in CASES}
        for name in chosen:
            with self.subTest(case=name):
                self.bench.prepare()
                with self.bench.falsified(FALSIFIED[name]), self.assertRaises(AssertionError):
                    cases[name].run(self.bench)


if __name__ == "__main__":
    unittest.main(verbosity=2)
