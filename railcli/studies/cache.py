"""What is kept to save time: contact tables and compiled code."""

import datetime

from railcli.files import kept_tables
from railcli.kernels import kept
from railcli.kernels.place import cache_root

from .answer import Answer

MB = 1e6


def shown():
    """What the cache holds, the tables that were used last first."""
    tables = kept_tables.kept()
    code = [(folder, sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()))
            for folder in kept.code_folders()]  # fmt: skip
    most = kept_tables.most_bytes()
    lines = [f"Cache: {cache_root()}", "", f"Contact tables, at most {most / 1e9:g} GB (RAILCLI_CACHE_GB):"]
    lines += [f"  {'last used':16}  {'MB':>6}  of"] if tables else ["  none"]
    for table in tables:
        when = datetime.datetime.fromtimestamp(table.used).strftime("%Y-%m-%d %H:%M")
        lines.append(f"  {when}  {table.size / MB:6.1f}  {table.about}")
    lines += ["", "Compiled code:", *(f"  {size / MB:6.1f} MB  {folder.name}{_now(folder)}" for folder, size in code)]
    total = sum(table.size for table in tables) + sum(size for _, size in code)
    lines += ["", f"Together {total / MB:.1f} MB; `railcli cache --empty` deletes them"]
    record = {
        "folder": cache_root(),
        "tables": [table._asdict() for table in tables],
        "most_bytes": most,
        "code": [{"folder": folder, "size": size, "in_use": bool(_now(folder))} for folder, size in code],
        "bytes": total,
    }
    return Answer(record, lines)


def emptied():
    """Delete all of it."""
    before = shown()
    kept_tables.forget_all()
    for folder in kept.code_folders():
        kept.forget(folder)
    after = shown()
    freed = before["bytes"] - after["bytes"]
    return Answer({"folder": cache_root(), "freed_bytes": freed}, [f"Freed {freed / MB:.1f} MB in {cache_root()}"])


def _now(folder):
    return ", of this version" if folder.name.endswith(kept.source_digest()) else ""
