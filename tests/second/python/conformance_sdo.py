"""Cases of SDO: each row of the table of commands, and each abort code that a server can raise."""

import binascii
import struct

from conformance_bench import (
    BLOCK_SIZE,
    CRC,
    INCOMPATIBLE,
    MEMORY,
    NO_DATA,
    NO_OBJECT,
    NO_SUB,
    NOT_STORED,
    RANGE,
    READ_ONLY,
    REQUEST,
    RESPONSE,
    SEQUENCE,
    TIMEOUT,
    TOGGLE,
    TOO_HIGH,
    TOO_LONG,
    TOO_LOW,
    TOO_SHORT,
    UNKNOWN_COMMAND,
    UNSUPPORTED,
    WRITE_ONLY,
    WRONG_STATE,
    Bench,
    abort,
    byte,
    case,
)
from conformance_devices import DEVICE

#: 6400h: a value of each type; sub-index 7 has four bytes, 27 has eight, 28 is limited. 6300h: bytes in blocks.
STORE = 0x6300
#: What a transfer may pause, and a little more, seconds.
SDO_TIMEOUT = 0.7


def block_crc(data: bytes) -> int:
    """CRC of block transfers: polynomial 1021h, from 0."""
    return binascii.crc_hqx(data, 0)


for name, request, response, upload in [
    ("4 bytes", "23 00 64 07 11 22 33 44", "60 00 64 07", "43 00 64 07 11 22 33 44"),
    ("3 bytes", "27 00 64 16 11 22 33", "60 00 64 16", "47 00 64 16 11 22 33"),
    ("2 bytes", "2B 00 64 06 11 22", "60 00 64 06", "4B 00 64 06 11 22"),
    ("1 byte", "2F 00 64 05 11", "60 00 64 05", "4F 00 64 05 11"),
    ("4 bytes, size not told", "22 00 64 07 55 66 77 88", "60 00 64 07", "43 00 64 07 55 66 77 88"),
    ("2 bytes, size not told", "22 00 64 06 55 66", "60 00 64 06", "4B 00 64 06 55 66"),
]:

    def expedited(bench: Bench, request=request, response=response, upload=upload) -> None:
        bench.exchange((request, response), (f"40 {request[3:11]}", upload))

    case(f"SDO: expedited, {name}", byte(0, 0x42))(expedited)


@case("SDO: segmented download, size told; upload with size", byte(0, 0x40))
def segmented(bench: Bench) -> None:
    bench.exchange(
        ("21 00 64 1B 08", "60 00 64 1B"),
        ("00 01 02 03 04 05 06 07", "20"),
        ("1D 08", "30"),
        ("40 00 64 1B", "41 00 64 1B 08"),
        ("60", "00 01 02 03 04 05 06 07"),
        ("70", "1D 08"),
    )


@case("SDO: segmented download, size not told", byte(0, 0x60))
def segmented_without_size(bench: Bench) -> None:
    bench.exchange(
        ("20 00 64 1B", "60 00 64 1B"),
        ("00 11 12 13 14 15 16 17", "20"),
        ("1D 18", "30"),
        ("40 00 64 1B", "41 00 64 1B 08"),
        ("60", "00 11 12 13 14 15 16 17"),
        ("70", "1D 18"),
    )


@case("SDO: a segmented download of four bytes is one, too")
def segmented_short(bench: Bench) -> None:
    bench.exchange(("21 00 64 07 04", "60 00 64 07"), ("07 0A 0B 0C 0D", "20"))
    bench.exchange(("40 00 64 07", "43 00 64 07 0A 0B 0C 0D"))


@case("SDO: an abort of the client ends a transfer and is not answered")
def aborted(bench: Bench) -> None:
    bench.exchange(("21 00 64 1B 08", "60 00 64 1B"), ("80 00 64 1B 00 00 00 08", ""))
    bench.hears_nothing(RESPONSE)
    bench.refuses("00", 0, 0, UNKNOWN_COMMAND)


@case("SDO: a new request ends the transfer before it")
def superseded(bench: Bench) -> None:
    bench.exchange(("21 00 64 1B 08", "60 00 64 1B"), ("40 18 10 04", "43 18 10 04 03"))
    bench.refuses("00", 0, 0, UNKNOWN_COMMAND)


def store(bench: Bench, data: bytes, crc: bool = True) -> None:
    """Downloads by blocks, all segments of a block at once."""
    command = 0xC6 if crc else 0xC2
    bench.send(REQUEST, struct.pack("<BHBI", command, STORE, 0, len(data)))
    answer = bench.wait_for(RESPONSE)
    assert answer[:4] == bytes([0xA4 if crc else 0xA0]) + struct.pack("<HB", STORE, 0), answer.hex(" ")
    size = answer[4]
    assert 1 <= size <= 127, f"a block of {size} segments"
    pieces = [data[at : at + 7] for at in range(0, len(data), 7)]
    while pieces:
        block, pieces = pieces[:size], pieces[size:]
        for number, piece in enumerate(block, 1):
            last = 0x80 if not pieces and number == len(block) else 0
            bench.send(REQUEST, bytes([last | number]) + piece.ljust(7, b"\0"))
        answer = bench.wait_for(RESPONSE)
        assert answer[:2] == bytes([0xA2, len(block)]), answer.hex(" ")
        size = answer[2]
    unused = -len(data) % 7
    bench.send(REQUEST, struct.pack("<BH5x", 0xC1 | unused << 2, block_crc(data) if crc else 0))
    bench.hears(RESPONSE, bytes([0xA1]).ljust(8, b"\0"))


def fetch(bench: Bench, data: bytes, crc: bool, block: int = 127) -> None:
    """Uploads by blocks."""
    bench.send(REQUEST, struct.pack("<BHBBB2x", 0xA4 if crc else 0xA0, STORE, 0, block, 0))
    bench.hears(RESPONSE, struct.pack("<BHBI", 0xC6 if crc else 0xC2, STORE, 0, len(data)))
    bench.send(REQUEST, bytes([0xA3]).ljust(8, b"\0"))
    pieces = [data[at : at + 7] for at in range(0, len(data), 7)]
    while pieces:
        now, pieces = pieces[:block], pieces[block:]
        for number, piece in enumerate(now, 1):
            last = 0x80 if not pieces and number == len(now) else 0
            bench.hears(RESPONSE, bytes([last | number]) + piece.ljust(7, b"\0"))
        bench.send(REQUEST, bytes([0xA2, len(now), block]).ljust(8, b"\0"))
    unused = -len(data) % 7
    bench.hears(RESPONSE, struct.pack("<BH5x", 0xC1 | unused << 2, block_crc(data) if crc else 0))
    bench.send(REQUEST, bytes([0xA1]).ljust(8, b"\0"))
    bench.is_there()


#: With a segment that is not full, and one that is.
TEXT, FULL = bytes(range(1, 31)), bytes(range(100, 128))

for crc in (True, False):

    def blocks(bench: Bench, crc=crc) -> None:
        for data in (TEXT, FULL):
            store(bench, data, crc)
            fetch(bench, data, crc)

    case(f"SDO: block transfers {'with' if crc else 'without'} CRC", byte(0, 0xC4))(blocks)


#: Clients end the block download of an empty value with one empty segment or none, and with 7 or 0 unused bytes.
for segments in (["81"], []):
    for unused in (7, 0):

        def empty(bench: Bench, segments=segments, unused=unused) -> None:
            store(bench, TEXT)
            bench.exchange((f"C6 {STORE & 0xFF:02X} {STORE >> 8:02X} 00", f"A4 {STORE & 0xFF:02X} {STORE >> 8:02X} 00 7F"))
            bench.exchange(*[(segment, "A2 01 7F") for segment in segments])
            bench.exchange((f"{0xC1 | unused << 2:02X}", "A1"))
            bench.exchange((f"40 {STORE & 0xFF:02X} {STORE >> 8:02X}", f"41 {STORE & 0xFF:02X} {STORE >> 8:02X}"), ("60", "0F"))

        case(f"SDO: a block download of nothing, {len(segments)} segments, {unused} bytes unused")(empty)


@case("SDO: an upload in blocks of one segment")
def single_segments(bench: Bench) -> None:
    store(bench, TEXT)
    fetch(bench, TEXT, True, block=1)


@case("SDO: blocks of more than 127 segments")
def long(bench: Bench) -> None:
    data = bytes(at * 7 % 251 for at in range(2_000))
    store(bench, data)
    fetch(bench, data, True)


@case("SDO: segments of a download that are lost are sent again")
def repeated_download(bench: Bench) -> None:
    data = bytes(range(21))
    bench.send(REQUEST, struct.pack("<BHBI", 0xC6, STORE, 0, len(data)))
    bench.wait_for(RESPONSE)
    bench.send(REQUEST, bytes([1]) + data[:7])
    bench.send(REQUEST, bytes([0x83]) + data[14:])
    answer = bench.wait_for(RESPONSE)
    assert answer[:2] == bytes([0xA2, 1]), answer.hex(" ")
    bench.send(REQUEST, bytes([1]) + data[7:14])
    bench.send(REQUEST, bytes([0x82]) + data[14:])
    answer = bench.wait_for(RESPONSE)
    assert answer[:2] == bytes([0xA2, 2]), answer.hex(" ")
    bench.send(REQUEST, struct.pack("<BH5x", 0xC1, block_crc(data)))
    bench.hears(RESPONSE, bytes([0xA1]).ljust(8, b"\0"))
    fetch(bench, data, True)


@case("SDO: segments of an upload that are lost are sent again")
def repeated_upload(bench: Bench) -> None:
    store(bench, TEXT)
    bench.send(REQUEST, struct.pack("<BHBBB2x", 0xA4, STORE, 0, 3, 0))
    bench.hears(RESPONSE, struct.pack("<BHBI", 0xC6, STORE, 0, len(TEXT)))
    bench.send(REQUEST, bytes([0xA3]).ljust(8, b"\0"))
    for number in range(3):
        bench.hears(RESPONSE, bytes([number + 1]) + TEXT[7 * number : 7 * number + 7])
    # Only the first one came.
    bench.send(REQUEST, bytes([0xA2, 1, 3]).ljust(8, b"\0"))
    for number in range(3):
        bench.hears(RESPONSE, bytes([number + 1]) + TEXT[7 * number + 7 : 7 * number + 14])
    bench.send(REQUEST, bytes([0xA2, 3, 3]).ljust(8, b"\0"))
    bench.hears(RESPONSE, bytes([0x81]) + TEXT[28:].ljust(7, b"\0"))
    bench.send(REQUEST, bytes([0xA2, 1, 3]).ljust(8, b"\0"))
    bench.hears(RESPONSE, struct.pack("<BH5x", 0xC1 | 5 << 2, block_crc(TEXT)))
    bench.send(REQUEST, bytes([0xA1]).ljust(8, b"\0"))
    bench.is_there()


@case("SDO: a short value is not uploaded by blocks when the client allows another protocol")
def threshold(bench: Bench) -> None:
    bench.exchange(("23 00 64 07 01 02 03 04", "60 00 64 07"))
    bench.exchange(("A4 00 64 07 7F 08", "43 00 64 07 01 02 03 04"))


# Abort codes.

for name, request, index, sub, code in [
    ("the command is unknown", "E0 00 64 07", 0, 0, UNKNOWN_COMMAND),
    ("a segment without transfer", "00 01 02 03 04 05 06 07", 0, 0, UNKNOWN_COMMAND),
    ("an upload segment without transfer", "60", 0, 0, UNKNOWN_COMMAND),
    ("a block end without transfer", "C1", 0, 0, UNKNOWN_COMMAND),
    ("read of write-only", struct.pack("<BHB", 0x40, *DEVICE.write_only).hex(), *DEVICE.write_only, WRITE_ONLY),
    ("write of read-only", "23 00 10 00 01", 0x1000, 0, READ_ONLY),
    ("write of a constant", "21 08 10 00 04", 0x1008, 0, READ_ONLY),
    ("segmented write of read-only", "21 18 10 04 04", 0x1018, 4, READ_ONLY),
    ("block write of read-only", "C2 18 10 04 04", 0x1018, 4, READ_ONLY),
    ("no object, read", "40 FF 5F 00", 0x5FFF, 0, NO_OBJECT),
    ("no object, write", "2F FF 5F 00 01", 0x5FFF, 0, NO_OBJECT),
    ("no object, by segments", "21 FF 5F 00 08", 0x5FFF, 0, NO_OBJECT),
    ("no object, block download", "C2 FF 5F 00 08", 0x5FFF, 0, NO_OBJECT),
    ("no object, block upload", "A0 FF 5F 00 7F", 0x5FFF, 0, NO_OBJECT),
    ("no sub-index, read", "40 18 10 05", 0x1018, 5, NO_SUB),
    ("no sub-index, write", "2F 00 64 FE 01", 0x6400, 0xFE, NO_SUB),
    ("no sub-index of a variable", "40 00 10 01", 0x1000, 1, NO_SUB),
    ("too long, expedited", "23 00 64 06 01 02 03 04", 0x6400, 6, TOO_LONG),
    ("too long, by segments", "21 00 64 1B 09", 0x6400, 27, TOO_LONG),
    ("too long, by blocks", "C2 00 64 1B 09", 0x6400, 27, TOO_LONG),
    ("too short, expedited", "2B 00 64 07 01 02", 0x6400, 7, TOO_SHORT),
    ("too short, by segments", "21 00 64 1B 07", 0x6400, 27, TOO_SHORT),
    ("a BOOLEAN of 2", "2F 00 64 01 02", 0x6400, 1, RANGE),
    ("above the limit", "2B 00 64 1C 65", 0x6400, 28, TOO_HIGH),
    ("below the limit", "2B 00 64 1C 9B FF", 0x6400, 28, TOO_LOW),
    ("a block of 0 segments", "A0 00 64 07 00", 0x6400, 7, BLOCK_SIZE),
    ("a block of 128 segments", "A0 00 64 07 80", 0x6400, 7, BLOCK_SIZE),
    ("not the signature of 1010h", "23 10 10 01 73 61 76 66", 0x1010, 1, NOT_STORED),
    ("not the signature of 1011h", "23 11 10 01 6C 6F 61 65", 0x1011, 1, NOT_STORED),
    ("an error that has not occurred", "40 03 10 08", 0x1003, 8, NO_DATA),
    ("a PDO that is valid", "2F 00 16 00 00", 0x1600, 0, UNSUPPORTED),
    ("one node consumed twice", "23 16 10 02 64 00 01 00", 0x1016, 2, INCOMPATIBLE),
]:

    def refused(bench: Bench, request=request, index=index, sub=sub, code=code) -> None:
        bench.refuses(request, index, sub, code)
        bench.is_there()

    case(f"SDO: {code:08X}h, {name}", byte(4, 0x77))(refused)


@case(f"SDO: {TOGGLE:08X}h, download")
def toggle_of_a_download(bench: Bench) -> None:
    bench.exchange(("21 00 64 1B 08", "60 00 64 1B"))
    bench.refuses("10 01 02 03 04 05 06 07", 0x6400, 27, TOGGLE)
    bench.refuses("00", 0, 0, UNKNOWN_COMMAND)


@case(f"SDO: {TOGGLE:08X}h, upload")
def toggle_of_an_upload(bench: Bench) -> None:
    bench.exchange(("40 00 64 1B", "41 00 64 1B 08"))
    bench.refuses("70", 0x6400, 27, TOGGLE)


@case(f"SDO: {UNKNOWN_COMMAND:08X}h, an upload's segment in a download")
def wrong_direction(bench: Bench) -> None:
    bench.exchange(("21 00 64 1B 08", "60 00 64 1B"))
    bench.refuses("60", 0x6400, 27, UNKNOWN_COMMAND)


@case(f"SDO: {TIMEOUT:08X}h, a client that does not go on")
def timeout(bench: Bench) -> None:
    bench.exchange(("21 00 64 1B 08", "60 00 64 1B"))
    bench.hears(RESPONSE, abort(0x6400, 27, TIMEOUT))
    bench.is_there()


@case(f"SDO: {TIMEOUT:08X}h, a block that does not begin")
def block_timeout(bench: Bench) -> None:
    bench.send(REQUEST, struct.pack("<BHBI", 0xC6, STORE, 0, 21))
    bench.wait_for(RESPONSE)
    bench.hears(RESPONSE, abort(STORE, 0, TIMEOUT))
    bench.is_there()


@case(f"SDO: {CRC:08X}h, of a download")
def wrong_crc(bench: Bench) -> None:
    bench.send(REQUEST, struct.pack("<BHBI", 0xC6, STORE, 0, 7))
    bench.wait_for(RESPONSE)
    bench.send(REQUEST, bytes([0x81]) + bytes(7))
    bench.wait_for(RESPONSE)
    bench.refuses(f"C1 {block_crc(bytes(7)) ^ 1:02X} 00", STORE, 0, CRC)


@case(f"SDO: {SEQUENCE:08X}h, more acknowledged than was sent")
def too_much_acknowledged(bench: Bench) -> None:
    store(bench, TEXT)
    bench.send(REQUEST, struct.pack("<BHBBB2x", 0xA0, STORE, 0, 2, 0))
    bench.wait_for(RESPONSE)
    bench.send(REQUEST, bytes([0xA3]).ljust(8, b"\0"))
    bench.wait_for(RESPONSE)
    bench.wait_for(RESPONSE)
    bench.refuses("A2 03 02", STORE, 0, SEQUENCE)


@case(f"SDO: {BLOCK_SIZE:08X}h, in an acknowledgement")
def wrong_block_size(bench: Bench) -> None:
    store(bench, TEXT)
    bench.send(REQUEST, struct.pack("<BHBBB2x", 0xA0, STORE, 0, 2, 0))
    bench.wait_for(RESPONSE)
    bench.send(REQUEST, bytes([0xA3]).ljust(8, b"\0"))
    bench.wait_for(RESPONSE)
    bench.wait_for(RESPONSE)
    bench.refuses("A2 02 00", STORE, 0, BLOCK_SIZE)


@case(f"SDO: {TOO_LONG:08X}h, more segments than were announced")
def more_than_announced(bench: Bench) -> None:
    bench.exchange(("21 00 64 1B 08", "60 00 64 1B"), ("00 01 02 03 04 05 06 07", "20"))
    bench.refuses("11 08 09 0A 0B 0C 0D 0E", 0x6400, 27, TOO_LONG)


@case(f"SDO: {TOO_SHORT:08X}h, fewer bytes than were announced")
def fewer_than_announced(bench: Bench) -> None:
    bench.exchange(("21 00 64 1B 08", "60 00 64 1B"))
    bench.refuses("01 01 02 03 04 05 06 07", 0x6400, 27, TOO_SHORT)


@case(f"SDO: {MEMORY:08X}h or {TOO_LONG:08X}h, more than a DOMAIN holds")
def too_much(bench: Bench) -> None:
    bench.send(REQUEST, struct.pack("<BHBI", 0x21, STORE, 0, 1 << 20))
    answer = bench.wait_for(RESPONSE)
    assert answer in (abort(STORE, 0, MEMORY), abort(STORE, 0, TOO_LONG)), answer.hex(" ")


@case(f"SDO: {WRONG_STATE:08X}h, a counter of SYNC while there is a period")
def wrong_state(bench: Bench) -> None:
    bench.write(0x1006, 0, 1_000_000, 4)
    bench.refuses("2F 19 10 00 0A", 0x1019, 0, WRONG_STATE)


@case("SDO: a request that is too short is not answered")
def short_request(bench: Bench) -> None:
    bench.send(REQUEST, "40 00 10")
    bench.is_there()
