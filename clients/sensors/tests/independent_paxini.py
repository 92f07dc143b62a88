#!/usr/bin/env python3
"""Our test vectors of the Paxini board, read by an independent decoder.

Needs Python 3.11 and `pip install paxini-sdk==0.1.0`. Says SKIPPED and ends with 77 where that is not there; ends with 1
when the two decoders differ. tests/vectors.rs holds our own decoder to the same table.
"""

import pathlib
import sys
import tomllib

try:
    from paxini_sdk import protocol, registers
except ImportError:
    print("SKIPPED: paxini-sdk is not installed (pip install paxini-sdk==0.1.0)")
    sys.exit(77)

TABLE = pathlib.Path(__file__).parent / "vectors" / "paxini.toml"


def read(data: bytes) -> list[str]:
    """What the independent decoder makes of a reply, in the words of the table."""
    try:
        reply = protocol.parse_fin_response(data)
    except Exception:
        return []
    if not reply.func_code & 0x80:
        return [f"acknowledged {reply.status}"]
    taxels = [reply.data[i : i + 3] for i in range(0, len(reply.data), 3)]
    values = [value for taxel in taxels for value in protocol.split_force_xyz(taxel)]
    condition = "normal" if reply.status in (0, 1) else "failed"
    return [f"frame - {reply.status} {condition}: {' '.join(map(str, values))}"]


def main() -> int:
    wrong = 0
    cases = tomllib.loads(TABLE.read_text())["case"]
    for case in cases:
        found = read(bytes.fromhex(case["hex"]))
        if found != case["expect"]:
            wrong += 1
            print(f"{case['about']}: the table says {case['expect']}, paxini-sdk {found}")
    # The request as it stands in the unit test of src/wire/paxini.rs, S2015E.
    asked = protocol.build_fin_request(
        protocol.FIN_FUNC_FORCE,
        registers.FIN_ADDR_DISTRIBUTED_FORCE,
        read=True,
        data_len=156,
    )
    if asked[:13] != bytes([0x55, 0xAA, 9, 0, 1, 0, 0xFB, 0x0E, 4, 0, 0, 156, 0]):
        wrong += 1
        print(f"the request differs: {asked.hex(' ')}")
    print(f"{len(cases)} vectors and 1 request, {wrong} differ")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
