# SPDX-License-Identifier: MIT
# Debian packages by `cpack`, one for each component of `cmake --install`. scripts/package makes them.
include(DebianText)
if(NOT TURNSCALE_BUILD_PROGRAM OR NOT TURNSCALE_BUILD_MANUAL)
  message(FATAL_ERROR "Debian packages need the program, help2man and gzip")
endif()

# Who makes the packages, as Debian's tools have it.
set(maintainer "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
if("$ENV{DEBFULLNAME}" STREQUAL "" OR "$ENV{DEBEMAIL}" STREQUAL "")
  set(maintainer "the turnscale authors <turnscale@invalid.invalid>")
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME turnscale)
# Each component has its own.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_SOURCE_DIR}/build/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
                                                WORLD_EXECUTE)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/StripLibraries.cmake)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${maintainer}")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_COMPONENTS_ALL "")

turnscale_debian_changelog(${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_BINARY_DIR}/packaging/changelog.gz
                           MAINTAINER "${maintainer}")

# turnscale_package(<component> NAME <package> SECTION <section> SUMMARY <line> DESCRIPTION <text> [DEPENDS <packages>]
# [RECOMMENDS <packages>] [SUGGESTS <packages>] [SCRIPTS <maintainer scripts>])
macro(turnscale_package component)
  cmake_parse_arguments(PACKAGE "" "NAME;SECTION;SUMMARY;DESCRIPTION" "DEPENDS;RECOMMENDS;SUGGESTS;SCRIPTS" ${ARGN})
  string(TOUPPER ${component} upper)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${PACKAGE_NAME})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${PACKAGE_SECTION})
  turnscale_wrap(general "${what}")
  turnscale_wrap(description "${PACKAGE_DESCRIPTION}")
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${PACKAGE_SUMMARY}\n${general}\n.\n${description}")
  foreach(relation IN ITEMS DEPENDS RECOMMENDS SUGGESTS)
    list(JOIN PACKAGE_${relation} ", " packages)
    set(CPACK_DEBIAN_${upper}_PACKAGE_${relation} "${packages}")
  endforeach()
  set(CPACK_DEBIAN_${upper}_PACKAGE_CONTROL_EXTRA "${PACKAGE_SCRIPTS}")
  install(
    FILES ${PROJECT_SOURCE_DIR}/packaging/copyright ${PROJECT_BINARY_DIR}/packaging/changelog.gz
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${PACKAGE_NAME}
    COMPONENT ${component}
    EXCLUDE_FROM_ALL)
endmacro()

# turnscale_python_scripts(<package> <folder>): maintainer scripts that compile Python files at installation and remove what
# was compiled, in the variable python_scripts.
function(turnscale_python_scripts package folder)
  set(python_scripts "")
  foreach(script IN ITEMS postinst prerm)
    configure_file(${PROJECT_SOURCE_DIR}/packaging/python-${script}.in ${PROJECT_BINARY_DIR}/packaging/${package}/${script}
                   @ONLY FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
                                          WORLD_EXECUTE)
    list(APPEND python_scripts ${PROJECT_BINARY_DIR}/packaging/${package}/${script})
  endforeach()
  set(python_scripts ${python_scripts} PARENT_SCOPE)
endfunction()

set(what
    "turnscale computes the path and the speed of a car from the images of one camera, without GPS or inertial sensors. The path is in metres: in turns, the known distance from rear axle to camera gives the scale."
)

turnscale_python_scripts(turnscale /usr/share/turnscale)
turnscale_package(
  program
  NAME turnscale
  SECTION science
  SUMMARY "metric visual odometry from one camera on a car"
  DESCRIPTION "This package contains the program turnscale, which reads folders of images, videos and ROS bags, and writes trajectories, a report, and tracks for maps."
  # Loaded when they are needed, so that dpkg-shlibdeps does not find them.
  DEPENDS
  ${FFmpegModules_RUNTIME_PACKAGES}
  # For `turnscale batch`.
  RECOMMENDS
  python3
  python3-dask
  python3-distributed
  python3-numpy
  SUGGESTS
  turnscale-simulator
  SCRIPTS
  ${python_scripts})

if(TARGET turnscale_simulator)
  turnscale_package(
    simulator
    NAME turnscale-simulator
    SECTION science
    SUMMARY "simulated drives for turnscale"
    DESCRIPTION "This package adds `turnscale simulate`, which renders the images of drives with known ground truth, and `turnscale lab`, which reproduces the experiments of the paper that turnscale builds on."
    DEPENDS "turnscale (= ${PROJECT_VERSION})")
endif()

turnscale_package(
  development
  NAME libturnscale-dev
  SECTION libdevel
  SUMMARY "metric visual odometry from one camera on a car - library"
  DESCRIPTION "This package contains the static libraries, their headers, and the files by which CMake finds them. Modules beyond the odometry itself need the recommended and suggested packages."
  DEPENDS
  libeigen3-dev
  libopencv-calib3d-dev
  libopencv-core-dev
  libopencv-features2d-dev
  libopencv-imgproc-dev
  libyaml-cpp-dev
  RECOMMENDS
  cmake
  ${FFmpegModules_RUNTIME_PACKAGES}
  libbz2-dev
  libcpp-httplib-dev
  libdeflate-dev
  libfmt-dev
  liblz4-dev
  libsqlite3-dev
  libturbojpeg0-dev
  libzstd-dev
  nlohmann-json3-dev
  SUGGESTS
  libembree-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)

if(TARGET turnscale_python)
  set(site lib/python3/dist-packages)
  get_target_property(python_source turnscale_python SOURCE_DIR)
  install(
    TARGETS turnscale_python
    LIBRARY DESTINATION ${site}/turnscale
            COMPONENT python3
            EXCLUDE_FROM_ALL)
  install(
    DIRECTORY ${python_source}/turnscale/
    DESTINATION ${site}/turnscale
    COMPONENT python3
    EXCLUDE_FROM_ALL
    FILES_MATCHING
    PATTERN "*.py"
    PATTERN "*.pyi"
    PATTERN "py.typed"
    PATTERN "__pycache__" EXCLUDE)
  # So that pip and importlib.metadata know the package.
  file(
    WRITE ${PROJECT_BINARY_DIR}/packaging/METADATA
    "Metadata-Version: 2.1\nName: turnscale\nVersion: ${PROJECT_VERSION}\nSummary: ${PROJECT_DESCRIPTION}\nLicense: MIT\nRequires-Dist: numpy\n"
  )
  install(
    FILES ${PROJECT_BINARY_DIR}/packaging/METADATA
    DESTINATION ${site}/turnscale-${PROJECT_VERSION}.dist-info
    COMPONENT python3
    EXCLUDE_FROM_ALL)
  turnscale_python_scripts(python3-turnscale "")
  # The extension module is made for one minor version of Python.
  math(EXPR next_minor "${Python_VERSION_MINOR} + 1")
  turnscale_package(
    python3
    NAME python3-turnscale
    SECTION python
    SUMMARY "metric visual odometry from one camera on a car - Python"
    DESCRIPTION "This package contains the Python module turnscale, which takes images and gives results as numpy arrays."
    DEPENDS
    "python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}~)"
    "python3 (<< ${Python_VERSION_MAJOR}.${next_minor})"
    python3-numpy
    ${FFmpegModules_RUNTIME_PACKAGES}
    SUGGESTS
    python3-matplotlib
    python3-pandas
    SCRIPTS
    ${python_scripts})
endif()

include(CPack)
