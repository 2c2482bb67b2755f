#!/usr/bin/env python3
"""Each rule of check_style.py catches a snippet that breaks it, and lets the corrected snippet pass."""

import pathlib
import tempfile
import unittest
import unittest.mock

import check_style

GLOSSARY = ("| Term | Meaning |\n|---|---|\n| spoilt | not a row of the table below |\n\n## Retired words\n\n| Retired | Use |\n"
            "|---|---|\n| fordo, fordone | damage |\n| worker | owner |\n\n| Instead of | Write |\n|---|---|\n| honest | right |\n")

# A tree that breaks no rule and needs every exception.
GOOD = {
    "docs/glossary.md": GLOSSARY,
    "src/parallel/comm.cpp": "void abort() {\n  MPI_Error_string(a);\n  MPI_Initialized(&b);\n  MPI_Finalized(&c);\n"
                             "  MPI_Comm_rank(PETSC_COMM_WORLD, &d);\n}\n",
    "src/parallel/petsc.cpp": "void report() {\n  PetscErrorMessage(code, &text, &detail);\n}\n",
    "src/distribution/exchange.cpp":
        "#include <mpi.h>\nvoid f() {\n  BULKLEY_MPI(MPI_Send(a, (b), g(c),\n                       d));\n}\n",
    "drivers/program/version.cpp": "bool f() {\n  return PetscGetVersion(a, 9) != 0 || MPI_Get_library_version(b, &n) != 0;\n}\n",
    "drivers/program/program.cpp": '#include "simulation/simulation.hpp"\n#include "bulkley/version.hpp"\nComm comm(MPI_COMM_WORLD);\n'
                           "int main() {\n  if (PetscInitialize(&n, &v) != 0) return 3;\n}\n",
}


def faults_of(files):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, text in files.items():
            file = root / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        return [f"{path}:{line}: {sentence}" for path, line, sentence in check_style.check_tree(root)]


@unittest.mock.patch.object(check_style, "WORD_EXCEPTIONS", set())
class CheckStyle(unittest.TestCase):

    def expect_fault(self, file, text, expected):
        found = faults_of({**GOOD, file: text})
        self.assertEqual(len(found), 1, found)
        self.assertIn(expected, found[0])
        self.assertTrue(found[0].startswith(file), found)

    def expect_none(self, file, text):
        self.assertEqual(faults_of({**GOOD, file: text}), [])

    def test_good_tree_passes(self):
        self.assertEqual(faults_of(GOOD), [])

    def test_later_module(self):
        self.expect_fault("src/distribution/a.cpp", '#include "integrator/step.hpp"\n', "later module 'integrator'")
        self.expect_fault("src/io/files/a.cpp", '#include "simulation/simulation.hpp"\n', "later module 'simulation'")
        self.expect_fault("src/particle/a.cpp", '#include "kernel/p2g.hpp"\n', "later module 'kernel'")
        self.expect_fault("src/base/a.cpp", '#include "bulkley/config/keys.hpp"\n', "later module 'config'")
        self.expect_fault("src/io/a.cpp", '#include "bulkley/program.hpp"\n', "later module 'drivers'")
        self.expect_none("src/integrator/a.cpp", '#include "field/field_grid.hpp"\n')

    def test_public_headers_include_public_ones(self):
        self.expect_fault("include/bulkley/particle/a.hpp", '#pragma once\n#include "config/keys.hpp"\n', "private config/keys.hpp")
        self.expect_none("include/bulkley/particle/a.hpp", '#pragma once\n#include "bulkley/config/keys.hpp"\n')

    def test_unknown_module(self):
        self.expect_fault("src/extra/a.cpp", "int a;\n", "no module")

    def test_core_without_mpi(self):
        self.expect_fault("src/kernel/a.cpp", "#include <mpi.h>\n", "without MPI, PETSc and HDF5, and includes mpi.h")
        self.expect_fault("src/material/laws/a.cpp", "#include <petscvec.h>\n", "includes petscvec.h")
        self.expect_fault("src/scene/a.cpp", "#include <hdf5.h>\n", "includes hdf5.h")
        self.expect_fault("src/scene/a.cpp", '#include "bulkley/parallel/comm.hpp"\n', "later module 'parallel'")
        self.expect_none("include/bulkley/parallel/comm.hpp", "#pragma once\n#include <mpi.h>\n")

    def test_exception_that_is_not_needed(self):
        found = faults_of({**GOOD, "src/parallel/petsc.cpp": "int a;\n"})
        self.assertEqual(len(found), 1)
        self.assertIn("not needed any more", found[0])

    def test_bare_calls(self):
        for call in ("MPI_Barrier(comm);", "(void)MPI_Send(a);", "PetscSFReduceBegin(sf);", "DMDAVecGetArray(dm);",
                     "VecSet(v, 0);", "KSPSolve(k, b, x);", "MatDestroy(&m);", "PCSetUp(p);",
                     "H5Fclose(file);", "(void)H5Fflush(file);", "if (open) H5Fclose(file);",
                     "auto code = MPI_Wait(&r, s);",
                     "BULKLEY_MPI(MPI_Send(a)); MPI_Wait(b);", "BULKLEY_ASSERT(MPI_Wait(b) == 0);"):
            self.expect_fault("src/distribution/a.cpp", f"void f() {{\n  {call}\n}}\n", "src/distribution/a.cpp:2: ")
        for line in ("// MPI_Barrier(comm) would hang here",
                     'throw RunError("MPI_Send(x) failed");', "double t = MPI_Wtime();",
                     "BULKLEY_PETSC(VecSet(v, f(0)));", "MPI_Comm comm = get();",
                     "if (H5Fclose(file) < 0) stop();",
                     "const HdfSpace space(H5Screate(H5S_SCALAR));", "return H5Tcopy(a);"):
            self.expect_none("src/distribution/a.cpp", f"void f() {{\n  {line}\n}}\n")
        self.expect_fault("src/base/log.cpp", "void f() {\n  MPI_Initialized(&a);\n}\n", "MPI_Initialized is called outside")

    def test_world_communicator(self):
        self.expect_fault("src/distribution/a.cpp", "auto c = MPI_COMM_WORLD;\n", "drivers and tests only")
        self.expect_fault("src/io/a.cpp", "auto c = PETSC_COMM_WORLD;\n", "drivers and tests only")
        self.expect_none("tests/mpi/a_mpi_test.cpp", "namespace bulkley::a_mpi_test {\nComm comm(MPI_COMM_WORLD);\n}\n")

    def test_namespace_of_a_test_file(self):
        for file in ("tests/unit/base/a_test.cpp", "tests/mpi/a_test.cpp"):
            self.expect_fault(file, "namespace bulkley {\n}\n", f"{file}:1: a test file's namespace ends with its name")
            self.expect_fault(file, "namespace bulkley::a_test_of {\n}\n", "a test file's namespace ends with its name")
            self.expect_none(file, "namespace bulkley::config::a_test {\n}\n")
        self.expect_none("tests/perf/a_test.cpp", "namespace bulkley {\n}\n")

    def test_headers(self):
        self.expect_fault("include/bulkley/base/a.hpp", "#include <vector>\n#pragma once\n", "#pragma once")
        self.expect_fault("include/bulkley/base/a.hpp", "#pragma once\nusing namespace std;\n", "using namespace")
        self.expect_none("include/bulkley/base/a.hpp", "#pragma once\nvoid f() {\n  using namespace detail;\n}\n")

    def test_long_file(self):
        self.expect_fault("src/base/a.cpp", "int a;\n" * 501, "more than 500 lines")
        self.expect_none("src/base/a.cpp", "int a;\n" * 500)

    def test_machine_paths(self):
        for path in ("/work" + "/main/out", "/tmp" + "/build_me", "/home" + "/ada/run"):
            self.expect_fault("docs/a.md", f"see {path}\n", "path of one machine")
        self.expect_none("docs/a.md", "the fluid's work/energy; out/home/ada\n")

    def test_retired_words(self):
        for file in ("include/bulkley/base/a.hpp", "drivers/a.py", "tests/a.py", "cluster/a.sh", "docs/a.md", "README.md"):
            first = "#pragma once\n" if file.endswith(".hpp") else "\n"
            for line in ("// a fordone file", "int n_fordone = 0;", "bool isFordone;", "Fordone."):
                self.expect_fault(file, first + line + "\n", f"{file}:2: 'fordone' is a retired word (docs/glossary.md): damage")
            self.expect_none(file, first + "// fordoneness, spoilt, honest\n")
        self.expect_fault("docs/a.md", "they fordo\n", "'fordo' is a retired word")
        self.expect_none("CHANGELOG.md", "a fordone file\n")
        self.expect_none("tests/style/a.py", "a fordone file\n")

    def test_exceptions_of_words(self):
        with unittest.mock.patch.object(check_style, "WORD_EXCEPTIONS", {("docs/old", "worker")}):
            self.expect_none("docs/old/a.md", "a worker\n")
            found = faults_of({**GOOD, "docs/old/a.md": "nothing\n"})
            self.assertEqual(len(found), 1, found)
            self.assertIn("the exception for 'worker' in docs/old is not needed any more", found[0])
            found = faults_of({**GOOD, "docs/old/a.md": "a worker\n", "docs/new.md": "a worker\n"})
            self.assertEqual([fault.split(":")[0] for fault in found], ["docs/new.md"])


if __name__ == "__main__":
    unittest.main()
