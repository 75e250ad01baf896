"""Spack package of the library and the driver.

`spack repo add tools/packaging/spack_repo/asperity`; then, in the folder of the sdist,
`spack install --no-checksum asperity`.
"""

import os

from spack.package import depends_on, license, variant, version
from spack_repo.builtin.build_systems.cmake import CMakePackage


class Asperity(CMakePackage):
    """Interface law for rough quasi-brittle interfaces: damage, friction, interlocking."""

    # Built with Spack 0.23, where CMakePackage was imported from spack.build_systems.cmake. Imports and
    # folders are those of Spack 1, which was not tried.

    manual_download = True

    license("BSD-3-Clause")

    version("0.1.0", url=f"file://{os.getcwd()}/asperity-0.1.0.tar.gz")

    variant("openmp", default=True, description="Spread arrays of points over threads")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("fortran", type="build")
    depends_on("cmake@3.22:", type="build")
    depends_on("lapack")

    def cmake_args(self):
        """Return the options of CMake."""
        return [self.define("ASPERITY_TESTS", False), self.define_from_variant("ASPERITY_OPENMP", "openmp")]
