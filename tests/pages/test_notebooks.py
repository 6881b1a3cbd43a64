"""The notebooks of the guides run from top to bottom; they are kept without outputs and say nothing of a machine."""

import ast
import json
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "docs" / "notebooks"
BOOKS = sorted(FOLDER.glob("*.ipynb"))


@pytest.fixture(scope="module")
def kernel(tmp_path_factory):
    """One kernel for all notebooks, so that packages are imported once."""
    pytest.importorskip("ipykernel")
    client = pytest.importorskip("nbclient")
    manager = client.client.KernelManager(kernel_name="python3")
    folder = str(tmp_path_factory.mktemp("notebooks"))
    manager.start_kernel(cwd=folder)
    yield manager, folder
    manager.shutdown_kernel(now=True)


@pytest.mark.parametrize("path", BOOKS, ids=lambda path: path.stem)
def test_every_cell_of_a_notebook_runs(kernel, path):
    import nbformat
    from nbclient import NotebookClient

    manager, folder = kernel
    book = nbformat.read(path, as_version=4)
    book.cells.insert(0, nbformat.v4.new_code_cell("%reset -f"))
    client = NotebookClient(book, km=manager, timeout=120, resources={"metadata": {"path": folder}})
    client.execute(cleanup_kc=False, reset_kc=True)
    for cell in book.cells[1:]:
        if cell.cell_type == "code" and isinstance(ast.parse(cell.source).body[-1], ast.Expr):
            assert cell.outputs, f"shows nothing:\n{cell.source}"


@pytest.mark.plain
@pytest.mark.nojit
@pytest.mark.parametrize("path", BOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_clean(path):
    text = path.read_text(encoding="utf-8")
    book = json.loads(text)
    code = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
    assert 2 <= len(code) <= 10
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)
    assert set(book["metadata"]) == {"kernelspec", "language_info"}
    assert book["metadata"]["language_info"] == {"name": "python"}
    assert "".join(book["cells"][0]["source"]).startswith("# ")
    assert all(place not in text for place in ("/home/", "/Users/", "C:\\\\", "/tmp/"))


@pytest.mark.plain
@pytest.mark.nojit
def test_every_guide_has_a_notebook_and_is_named_with_it():
    listed = (FOLDER.parent / "notebooks.md").read_text(encoding="utf-8")
    assert len(BOOKS) >= 15
    for path in BOOKS:
        assert f"(notebooks/{path.name})" in listed or f"<notebooks/{path.name}>" in listed
        assert (FOLDER.parent / f"{path.stem}.md").is_file(), f"no guide {path.stem}"
