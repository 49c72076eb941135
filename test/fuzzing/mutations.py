# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Ways to damage a file: its bytes, its text, its arrays, and the place where it lies.

A mutation library would bring a byte mutator of the same few lines; what finds defects here is
knowing the formats: numbers in headers, YAML's tags and aliases, arrays in archives.
"""

from collections.abc import Callable
from functools import cache
import io
from pathlib import Path
import re
import shutil
import zipfile

import numpy as np

MARKER = 'executed_from_a_file'
"""File that the payloads below create if anybody executes them."""

_EXTREMES = (0, 1, -1, 2**7, 2**15, 2**16 - 1, 2**31 - 1, -(2**31), 2**32 - 1, 2**62, -(2**63))
_TEXT_NUMBERS = (
    *(str(number).encode() for number in _EXTREMES),
    *(b'1e308', b'-1e308', b'1e-320', b'nan', b'inf', b'-inf', b'0x10', b'1_0', b'', b'1.5'),
    *(b'9' * 40, b'9' * 5000, b'[]', b'null', b'true', b'"text"', b'2001-99-99', b'\xff'),
)
_NUMBER = re.compile(rb'-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?')
_PICKLE = b'cos\nsystem\n(S"touch %s"\ntR.' % MARKER.encode()
_HEADER_BYTES = 256  # where formats keep their sizes
_BOMB_SHARE = 0.004  # of archives unpack to gigabytes


def damage_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    """Return ``data`` after one to three mutations that know nothing of its format."""
    for _ in range(rng.integers(1, 4)):
        data = _BYTE_MUTATIONS[rng.integers(len(_BYTE_MUTATIONS))](data, rng)
    return data


def damage_text(data: bytes, rng: np.random.Generator) -> bytes:
    """Return a text file after mutations of its numbers and lines, sometimes of its bytes."""
    for _ in range(rng.integers(1, 4)):
        data = _TEXT_MUTATIONS[rng.integers(len(_TEXT_MUTATIONS))](data, rng)
    return data


def damage_yaml(data: bytes, rng: np.random.Generator) -> bytes:
    """Return a YAML file with a trick of the language in it, or damaged as text."""
    if rng.random() < 0.4:
        return damage_text(data, rng)
    trick = YAML_TRICKS[rng.integers(len(YAML_TRICKS))]
    values = list(re.finditer(rb'(?<=: )\S[^\n]*', data))
    match rng.integers(3):
        case 0 if values:  # in place of a value
            chosen = values[rng.integers(len(values))]
            return data[: chosen.start()] + b'\n  ' + trick + data[chosen.end() :]
        case 1:
            return data + b'\nextra: ' + trick + b'\n'
        case _:
            return trick


def damage_archive(data: bytes, rng: np.random.Generator) -> bytes:
    """Return a ``.npz`` file that is a good archive of bad arrays."""
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    members = {name: npy_bytes(array) for name, array in arrays.items()}
    if rng.random() < _BOMB_SHARE:
        return _zip_bomb(next(iter(members)))
    for _ in range(rng.integers(1, 3)):
        name = sorted(arrays)[rng.integers(len(arrays))]
        members[name] = damage_npy(arrays[name], rng)
        if members[name] == b'':
            del members[name]
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, 'w', zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(f'{name}.npy', content)
    return buffer.getvalue()


def damage_npy(array: np.ndarray, rng: np.random.Generator) -> bytes:
    """Return a ``.npy`` file of another type, shape or content; empty to leave it out."""
    match rng.integers(10):
        case 0:
            return b''
        case 1:
            return npy_bytes(array.astype(str))
        case 2:
            return npy_bytes(array.reshape(-1)[: rng.integers(array.size + 1)])
        case 3:
            return npy_bytes(array[None])
        case 4:
            return npy_bytes(np.array([Payload()], dtype=object), allow_pickle=True)
        case 5:
            return lying_npy('<f8', (2**28,))
        case 6:
            return lying_npy('<f8', (int(_EXTREMES[rng.integers(len(_EXTREMES))]), 3))
        case 7:
            return damage_bytes(npy_bytes(array), rng)
        case _:
            return npy_bytes(_with_bad_values(array, rng))


def damage_place(path: Path, rng: np.random.Generator) -> None:
    """Put something else where the file is expected."""
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink()
    match rng.integers(4):
        case 0:
            path.mkdir()
        case 1:
            path.write_bytes(b'')
        case 2:
            path.symlink_to(path.name)  # a link to itself


class Payload:
    """Unpickling this creates the marker."""

    def __reduce__(self) -> tuple[Callable[..., object], tuple[str]]:
        return Path.touch, (Path(MARKER),)  # type: ignore[return-value]


def npy_bytes(array: np.ndarray, allow_pickle: bool = False) -> bytes:
    """Return the bytes of a ``.npy`` file."""
    buffer = io.BytesIO()
    np.save(buffer, array, allow_pickle=allow_pickle)
    return buffer.getvalue()


def lying_npy(kind: str, shape: tuple[int, ...], zeros: int = 1 << 20) -> bytes:
    """Return a ``.npy`` file whose header promises another shape than ``zeros`` bytes."""
    header = repr({'descr': kind, 'fortran_order': False, 'shape': shape}).encode()
    header += b' ' * (63 - (len(header) + 10) % 64) + b'\n'
    return b'\x93NUMPY\x01\x00' + len(header).to_bytes(2, 'little') + header + bytes(zeros)


@cache
def _zip_bomb(name: str) -> bytes:
    """Return an archive of one array of zeros that needs three gigabytes."""
    buffer, count = io.BytesIO(), 3 * 2**30 // 8
    with (
        zipfile.ZipFile(buffer, 'w', zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open(f'{name}.npy', 'w', force_zip64=True) as member,
    ):
        member.write(lying_npy('<f8', (count,), zeros=0))
        for _ in range(8 * count // 2**20):
            member.write(bytes(2**20))
    return buffer.getvalue()


def _with_bad_values(array: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    if array.dtype.kind not in 'iufb' or not array.size:
        return np.array(_EXTREMES[rng.integers(len(_EXTREMES))])
    bad = array.copy()
    chosen = rng.integers(bad.size, size=rng.integers(1, 4))
    extreme = [np.nan, np.inf, 1e300, -1e300] if bad.dtype.kind == 'f' else _EXTREMES
    with np.errstate(all='ignore'):
        value = np.array(extreme[rng.integers(len(extreme))]).astype(bad.dtype, casting='unsafe')
    bad.reshape(-1)[chosen] = value
    return bad


def _place(data: bytes, rng: np.random.Generator) -> int:
    limit = len(data) if rng.random() < 0.5 else min(len(data), _HEADER_BYTES)
    return int(rng.integers(limit + 1))


def _flip(data: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(data)
    for _ in range(rng.integers(1, 9)):
        if changed:
            changed[min(_place(data, rng), len(changed) - 1)] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def _truncate(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: _place(data, rng)]


def _insert(data: bytes, rng: np.random.Generator) -> bytes:
    at = _place(data, rng)
    chunks = (rng.bytes(int(rng.integers(1, 65))), b'\0' * 64, b'\xff' * 64, _PICKLE)
    return data[:at] + chunks[rng.integers(len(chunks))] + data[at:]


def _duplicate(data: bytes, rng: np.random.Generator) -> bytes:
    start, end = sorted((_place(data, rng), _place(data, rng)))
    return data[:end] + data[start:end] * int(rng.integers(1, 4)) + data[end:]


def _delete(data: bytes, rng: np.random.Generator) -> bytes:
    start, end = sorted((_place(data, rng), _place(data, rng)))
    return data[:start] + data[end:]


def _set_integer(data: bytes, rng: np.random.Generator) -> bytes:
    """Overwrite 1 to 8 bytes, as a header's size, by an extreme integer in either byte order."""
    width, at = int(rng.choice([1, 2, 4, 8])), _place(data, rng)
    number = _EXTREMES[rng.integers(len(_EXTREMES))] % 2 ** (8 * width)
    order = 'little' if rng.random() < 0.7 else 'big'
    return data[:at] + number.to_bytes(width, order) + data[at + width :]


def _set_number(data: bytes, rng: np.random.Generator) -> bytes:
    numbers = list(_NUMBER.finditer(data))
    if not numbers:
        return _insert(data, rng)
    chosen = numbers[rng.integers(min(len(numbers), 40 if rng.random() < 0.5 else 10**9))]
    value = _TEXT_NUMBERS[rng.integers(len(_TEXT_NUMBERS))]
    return data[: chosen.start()] + value + data[chosen.end() :]


def _swap_lines(data: bytes, rng: np.random.Generator) -> bytes:
    lines = data.split(b'\n')
    first, second = rng.integers(len(lines), size=2)
    lines[first], lines[second] = lines[second], lines[first]
    return b'\n'.join(lines)


def _drop_line(data: bytes, rng: np.random.Generator) -> bytes:
    lines = data.split(b'\n')
    del lines[rng.integers(len(lines))]
    return b'\n'.join(lines)


def _drop_word(data: bytes, rng: np.random.Generator) -> bytes:
    words = data.split(b' ')
    del words[rng.integers(len(words))]
    return b' '.join(words)


_BYTE_MUTATIONS = (_flip, _truncate, _insert, _duplicate, _delete, _set_integer, _set_number)
_TEXT_MUTATIONS = (
    *(_set_number, _set_number, _swap_lines, _drop_line, _drop_word),
    *(_flip, _truncate, _insert, _duplicate, _delete),
)


def _laughs(depth: int, width: int) -> bytes:
    """Return nested aliases of ``width ** depth`` leaves in a few hundred bytes."""
    lines = [b'a0: &a0 [lol, lol]']
    for level in range(1, depth):
        lines.append(
            b'a%d: &a%d [%s]' % (level, level, b', '.join([b'*a%d' % (level - 1)] * width))
        )
    return b'{' + b', '.join(lines) + b'}'


def _merges(depth: int, width: int) -> bytes:
    """Return nested merge keys, which a loader expands while it reads."""
    lines = [b'a0: &a0 {x: 1}']
    for level in range(1, depth):
        merged = b', '.join([b'*a%d' % (level - 1)] * width)
        lines.append(b'a%d: &a%d {<<: [%s]}' % (level, level, merged))
    return b'{' + b', '.join(lines) + b'}'


YAML_TRICKS = (
    b'!!python/object/apply:os.system ["touch %s"]' % MARKER.encode(),
    b'!!python/object/new:pathlib.Path [%s]' % MARKER.encode(),
    b'!!python/name:os.system',
    b'!!python/module:antigravity',
    b'!!binary "//8="',
    b'!!timestamp 2001-99-99',
    b'!!float abc',
    b'!!int ' + b'9' * 5000,
    b'!!set {a, b}',
    b'!unknown {a: b}',
    b'&self [*self]',
    b'&self {a: *self}',
    b'*missing',
    b'[' * 3000 + b']' * 3000,
    b'{a: ' * 500 + b'1' + b'}' * 500,
    b'{? [a, b] : c}',
    b'{? {a: b} : c}',
    b'{1: 2, null: 3, .nan: 4}',
    b'{a: 1, a: 2}',
    b'"\\x1b[2J\\x07\\u202e"',
    b'\x1b[2J',
    b'\xef\xbb\xbf',
    b'\xff\xfe',
    b'"\\ud800"',
    b'.nan',
    b'-.inf',
    b'1e999',
    b'1:30:00',
    b'%YAML 9.9\n---\n',
    b'---\na: 1\n---\nb: 2\n',
    b'\t- a',
    b'|\n' + b'x' * 100_000,
    b'../../../../../../etc/passwd',
    b'/dev/zero',
    b'"a\\0b"',
    b'"' + b'n' * 5000 + b'"',
    _laughs(9, 9),
    _laughs(30, 3),
    _merges(9, 9),
)
