# Sets LOCKSTEP_PYTHON to whether the Python module is built. Debian's Python, whose packages scripts/install-packages
# installs, is preferred to others that may stand before it in PATH; -DPython3_EXECUTABLE=... chooses.
if(SKBUILD)  # of a wheel, which is for the Python that builds it and needs NumPy only to run
  set(Python3_EXECUTABLE ${Python_EXECUTABLE})
elseif(NOT Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "The Python that the module is built for and tested with")
endif()
find_package(Python3 COMPONENTS Interpreter Development.Module OPTIONAL_COMPONENTS NumPy)
find_package(pybind11 CONFIG)
if(Python3_Development.Module_FOUND AND (Python3_NumPy_FOUND OR SKBUILD) AND pybind11_FOUND)
  set(LOCKSTEP_PYTHON ON)
elseif(LOCKSTEP_PYTHON STREQUAL "AUTO")
  message(STATUS "no Python module: pybind11, NumPy or Python's headers are missing (python3-dev, pybind11-dev, "
    "python3-numpy)")
  set(LOCKSTEP_PYTHON OFF)
else()
  message(FATAL_ERROR "LOCKSTEP_PYTHON is ON, and pybind11, NumPy or Python's headers are missing; install python3-dev, "
    "pybind11-dev and python3-numpy, or give -DPython3_EXECUTABLE=")
endif()
