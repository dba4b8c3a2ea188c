"""Runs the image of judge/image in QEMU and in this core, and compares what both print. See README.md.

Assembles the image with LLVM, runs it in qemu-system-arm, writes image.bin and answers.txt to twin/tests/qemu, and starts
tests/qemu.rs. The exit code is 1 if a line differs without a reason in README.md, 2 if a tool is missing or fails.

usage: qemu.py
"""

import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
IMAGE, BUILD, ANSWERS = HERE / "image", ROOT / "target" / "judge", HERE.parent / "tests" / "qemu"
ASSEMBLE = ["llvm-mc", "-triple=thumbv7em-none-eabihf", "-mcpu=cortex-m4", "-filetype=obj"]
EMULATE = ["qemu-system-arm", "-M", "netduinoplus2", "-icount", "shift=0", "-nographic",
           "-semihosting-config", "enable=on,target=native"]
TOOLS = {"llvm-mc": "llvm", "llvm-objcopy": "llvm", "ld.lld": "lld", "qemu-system-arm": "qemu-system-arm"}
SECONDS = 60
LIMIT = 64 * 1024


def fail(text):
    print(f"qemu.py: {text}", file=sys.stderr)
    sys.exit(2)


def run(command, **options):
    try:
        return subprocess.run([str(part) for part in command], check=True, timeout=SECONDS, **options)
    except subprocess.CalledProcessError as error:
        fail(f"{command[0]} ended with {error.returncode}: {(error.stderr or b'').decode(errors='replace')[-2000:]}")
    except subprocess.TimeoutExpired as error:
        fail(f"{command[0]} has not ended after {SECONDS} s: {(error.stderr or b'').decode(errors='replace')[-2000:]}")


def build():
    """Assembles and links the image. Returns its ELF file."""
    objects = []
    for source in sorted(IMAGE.glob("*.s")):
        if source.name != "macros.s":
            objects.append(BUILD / f"{source.stem}.o")
            run(ASSEMBLE + ["-I", IMAGE, "-o", objects[-1], source])
    elf = BUILD / "image.elf"
    run(["ld.lld", "-T", IMAGE / "image.ld", "-o", elf] + objects, stderr=subprocess.PIPE)
    binary = ANSWERS / "image.bin"
    run(["llvm-objcopy", "-O", "binary", elf, binary])
    if binary.stat().st_size > LIMIT:
        fail(f"the image has {binary.stat().st_size} bytes; at most {LIMIT} are allowed")
    return elf


def main():
    if len(sys.argv) > 1:
        fail(f"unknown argument {sys.argv[1]!r}; this script takes none")
    missing = sorted({package for tool, package in TOOLS.items() if not shutil.which(tool)})
    if missing:
        fail(f"missing tools; install them with: apt-get install {' '.join(missing)}")
    BUILD.mkdir(parents=True, exist_ok=True)
    ANSWERS.mkdir(exist_ok=True)
    elf = build()
    # Semihosting of QEMU prints to the standard error output.
    printed = run(EMULATE + ["-kernel", elf], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE).stderr
    (ANSWERS / "answers.txt").write_bytes(printed)
    version = run(["qemu-system-arm", "--version"], stdout=subprocess.PIPE).stdout.decode().splitlines()[0]
    print(f"{version}: {len(printed.splitlines())} lines", flush=True)
    test = ["cargo", "test", "--quiet", "-p", "can-twin", "--test", "cpu", "qemu", "--", "--nocapture"]
    sys.exit(1 if subprocess.run(test, cwd=ROOT, check=False).returncode else 0)


main()
