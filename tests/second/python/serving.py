"""An SDO server of the canopen package: node 5 of the nominal bus, until its standard input ends.

It says when it is there, and then what is written to it: index, sub-index, bytes. Blocks it does not know: a block upload
is answered with segments, a block download refused (canopen/sdo/server.py).
"""

import sys

from canopen import LocalNode
from canopen.objectdictionary import ObjectDictionary, ODRecord, ODVariable, datatypes

from spacecraft import network

NODE = 5


def pattern(size: int) -> bytes:
    """Bytes that differ from their neighbours; the test knows them, too."""
    return bytes(at * 167 % 251 for at in range(size))


def dictionary() -> ObjectDictionary:
    """Objects by type and size; `Constant` and `Text` cannot be written."""
    found = ObjectDictionary()
    for name, index, data_type, access, value in [
        ("Byte", 0x2001, datatypes.UNSIGNED8, "rw", 0x5A),
        ("Word", 0x2002, datatypes.UNSIGNED16, "rw", 0x1234),
        ("Three bytes", 0x2003, datatypes.UNSIGNED24, "rw", 0x123456),
        ("Long", 0x2004, datatypes.UNSIGNED32, "rw", 0x12345678),
        ("Eight bytes", 0x2005, datatypes.UNSIGNED64, "rw", 0x123456789ABCDEF0),
        ("String", 0x2006, datatypes.VISIBLE_STRING, "rw", "ECSS-E-ST-50-15C " * 6),
        ("Octets", 0x2007, datatypes.OCTET_STRING, "rw", pattern(100)),
        ("Domain", 0x2008, datatypes.DOMAIN, "rw", pattern(1000)),
        ("Constant", 0x2009, datatypes.UNSIGNED32, "ro", 1),
        ("Text", 0x200A, datatypes.VISIBLE_STRING, "ro", "a hundred bytes"),
        ("Key", 0x200B, datatypes.UNSIGNED32, "wo", 0),
        ("Nothing", 0x200C, datatypes.UNSIGNED32, "rw", None),
    ]:
        variable = ODVariable(name, index)
        variable.data_type, variable.access_type, variable.default = data_type, access, value
        found.add_object(variable)
    record = ODRecord("Record", 0x2010)
    for subindex in (0, 1):
        member = ODVariable(f"Member {subindex}", record.index, subindex)
        member.data_type, member.access_type, member.default = datatypes.UNSIGNED8, "ro", 1
        record.add_member(member)
    found.add_object(record)
    return found


def tell(index: int, subindex: int, data: bytes, **_: object) -> None:
    """What was written."""
    print(f"{index:04X} {subindex:02X} {data.hex()}", flush=True)


if __name__ == "__main__":
    with network() as net:
        node = LocalNode(NODE, dictionary())
        node.add_write_callback(tell)
        net.add_node(node)
        print("serving", flush=True)
        sys.stdin.read()
