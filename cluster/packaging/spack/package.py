# A recipe for Spack. There is no public archive yet: the source is the file that cluster/release.sh makes,
# bulkley-VERSION.tar.gz, expected in the folder in which spack is called; see docs/clusters.md.

import os

from spack.package import *


class Bulkley(CMakePackage):
    """Distributed Material Point Method solver for Herschel-Bulkley fluids and soft solids, the same bits on any number of
    ranks."""

    manual_download = True

    license("BSD-3-Clause", checked_by="its authors")

    version("0.2.0")

    variant("python", default=True, description="NumPy, h5py and Matplotlib for the scripts that measure and plot runs")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("pkgconfig", type="build")

    depends_on("mpi")
    depends_on("petsc@3.18: ~complex +mpi +hdf5")
    depends_on("hdf5 +mpi")
    depends_on("eigen@3.4:3")
    depends_on("metis@5:")
    depends_on("fmt@9:")
    depends_on("tomlplusplus@3.3:")
    depends_on("cli11@2:")
    depends_on("nlohmann-json@3.11:")
    depends_on("muparser@2.3:")
    depends_on("zlib-api")

    with when("+python"):
        depends_on("python@3.11:", type="run")
        depends_on("py-numpy", type="run")
        depends_on("py-h5py", type="run")
        depends_on("py-matplotlib", type="run")

    conflicts("%gcc@:11", msg="Bulkley needs C++20 as GCC 12 has it")

    def url_for_version(self, version):
        return f"file://{os.getcwd()}/bulkley-{version}.tar.gz"

    def cmake_args(self):
        # Spack's compiler wrapper names the processor itself.
        return [self.define("BULKLEY_NATIVE", False), self.define("BULKLEY_TESTS", False)]

    def setup_run_environment(self, env):
        share = self.prefix.share.bulkley
        env.set("BULKLEY_SHARE", share)
        env.set("BULKLEY_SCRIPTS", share.jobs)

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def check_install(self):
        bulkley = Executable(self.prefix.bin.bulkley)
        bulkley("--version")
        bulkley("check", join_path(self.prefix.share.bulkley.scenes, "cream_splash.toml"))
