"""The file `verdicts.json` with all findings of a results folder."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from mpmverify.atomic import write_atomic
from mpmverify.dataset.files import Results, set_aside
from mpmverify.errors import ResultsError
from mpmverify.judgement.findings import Finding

BEGINNING = b'{\n "schema": 1,\n "studies": {'


@dataclass(frozen=True)
class StoredVerdicts:
    """Findings of one study, and the inputs of its file.

    Parameters
    ----------
    findings : tuple of Finding
        The findings.
    inputs : str
        Digest of everything that the study's file depends on.
    checksum : str
        Digest of the study's file.
    """

    findings: tuple[Finding, ...]
    inputs: str
    checksum: str

    def made_from(self, inputs: str, path: Path) -> bool:
        """Whether these findings and the study's file at `path`, which has not changed since, were both made from these inputs."""
        return self.inputs == inputs and path.is_file() and self.checksum == _checksum(path)


def read_verdicts(results: Results) -> dict[str, StoredVerdicts]:
    """Return the stored findings by study; empty if there is no file, or a damaged one, which is set aside.

    Raises
    ------
    ResultsError
        If the file was not written by mpmverify.
    """
    path = results.verdicts
    if not path.exists():
        return {}
    try:
        content = path.read_bytes()
        return {
            name: StoredVerdicts(
                tuple(Finding.of(finding) for finding in entry["findings"]), entry["inputs"], entry.get("checksum", "")
            )
            for name, entry in json.loads(content)["studies"].items()
        }
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, OSError) or (content.strip(b"\0") and not BEGINNING.startswith(content[: len(BEGINNING)])):
            raise ResultsError(f"'{path}' is not a list of mpmverify verdicts: delete it and run again") from error
    set_aside(path)
    return {}


def write_verdicts(results: Results, study: str, inputs: str, findings: Sequence[Finding]) -> None:
    """Replace the findings of one study, after its file was written, and drop those of studies without a file.

    Raises
    ------
    ResultsError
        If the file was not written by mpmverify, or cannot be written.
    """
    kept = {name: entry for name, entry in read_verdicts(results).items() if results.study(name).exists()}
    kept[study] = StoredVerdicts(tuple(findings), inputs, _checksum(results.study(study)))
    body = {"schema": 1, "studies": {name: asdict(entry) for name, entry in kept.items()}}
    text = json.dumps(body, indent=1, sort_keys=True) + "\n"
    write_atomic(results.verdicts, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def _checksum(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
