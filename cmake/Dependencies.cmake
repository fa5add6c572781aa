# Finds Eigen, nlohmann-json, the FMI headers and (for the Python module) nanobind: installed ones, or those of the Python
# packages cmeel-eigen, nlohmann-json, fmpy and nanobind. The private environment .venv is looked at first.

if(NOT DEFINED Python_ROOT_DIR AND NOT DEFINED ENV{VIRTUAL_ENV} AND EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/.venv/bin/python
   AND NOT DEFINED Python_EXECUTABLE)
  set(Python_ROOT_DIR ${CMAKE_CURRENT_SOURCE_DIR}/.venv)
endif()
set(Python_FIND_VIRTUALENV FIRST)
if(SIGMAFMU_PYTHON)
  find_package(Python 3.10 REQUIRED COMPONENTS Interpreter Development.Module)
else()
  find_package(Python 3.10 REQUIRED COMPONENTS Interpreter)
endif()

# Directories of installed Python packages that hold headers or CMake files.
execute_process(
  COMMAND ${Python_EXECUTABLE} -c
"import importlib.util as u, pathlib as p, sysconfig, sys
def where(name):
    s = u.find_spec(name)
    return p.Path(s.origin).parent if s and s.origin else None
paths = [p.Path(x) / 'cmeel.prefix' for x in sys.path]
fmpy, nanobind, json = where('fmpy'), where('nanobind'), where('nlohmann_json')
print(';'.join(str(x) for x in paths if x.is_dir()))
print(fmpy / 'c-code' if fmpy else '')
print(nanobind / 'cmake' if nanobind else '')
print(json / 'include' if json else '')"
  OUTPUT_VARIABLE SIGMAFMU_PYTHON_DIRS OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE ";" "|" SIGMAFMU_PYTHON_DIRS "${SIGMAFMU_PYTHON_DIRS}")
string(REPLACE "\n" ";" SIGMAFMU_PYTHON_DIRS "${SIGMAFMU_PYTHON_DIRS};;;")
list(GET SIGMAFMU_PYTHON_DIRS 0 CMEEL_PREFIXES)
list(GET SIGMAFMU_PYTHON_DIRS 1 FMPY_HEADERS)
list(GET SIGMAFMU_PYTHON_DIRS 2 NANOBIND_CMAKE)
list(GET SIGMAFMU_PYTHON_DIRS 3 JSON_HEADERS)
string(REPLACE "|" ";" CMEEL_PREFIXES "${CMEEL_PREFIXES}")
list(APPEND CMAKE_PREFIX_PATH ${CMEEL_PREFIXES})

set(SIGMAFMU_HINT "`make setup` installs it into .venv; or see \"Building without make\" in docs/development.md.")

find_package(Eigen3 3.4 NO_MODULE QUIET)
if(NOT Eigen3_FOUND)
  message(FATAL_ERROR "Eigen 3.4 was not found. ${SIGMAFMU_HINT}")
endif()

find_path(NLOHMANN_JSON_INCLUDE_DIR nlohmann/json.hpp HINTS ${JSON_HEADERS} DOC "Folder that holds nlohmann/json.hpp")
if(NOT NLOHMANN_JSON_INCLUDE_DIR)
  message(FATAL_ERROR "nlohmann/json.hpp was not found; set NLOHMANN_JSON_INCLUDE_DIR. ${SIGMAFMU_HINT}")
endif()

find_path(FMI2_INCLUDE_DIR fmi2Functions.h HINTS ${FMPY_HEADERS} DOC "Folder of the FMI 2.0 headers")
if(NOT FMI2_INCLUDE_DIR)
  message(FATAL_ERROR "The FMI 2.0 headers were not found; set FMI2_INCLUDE_DIR. ${SIGMAFMU_HINT}")
endif()

if(SIGMAFMU_PYTHON)
  find_package(nanobind CONFIG REQUIRED HINTS ${NANOBIND_CMAKE})
endif()
