# QUOIN_QUICK_BUILD: from nothing in less processor time. Files of a folder are compiled in batches (unity builds); headers
# of libraries are precompiled where files change too often for that. Off, the default, each file is compiled alone with
# what it includes, which finds what a file leaves out. scripts/test has it on where nothing is built yet.
if(NOT QUOIN_QUICK_BUILD)
  return()
endif()

# target:files a batch:files that are compiled alone. Names at namespace scope, anonymous ones too, must differ within a
# batch: a "redefinition" is mended by another name, or by an entry here.
set(batches
    quoin-check-law:9
    quoin_adapter_shared:3
    quoin_geometry:7:drawn_shape.cpp
    quoin_random:4
    quoin_records:6:pulses.cpp
    quoin_files:5
    quoin_scene:10:generate_building.cpp,read_building.cpp,size.cpp
    quoin_host_law:5:law_trial.cpp
    quoin_host_path:3
    quoin_members:6
    quoin_model:14:undamaged_kernels.cpp,zone_kernels.cpp
    quoin_step:14:body_kernels.cpp,deformable_kernels.cpp,contact_kernels.cpp,implicit_contacts.cpp,kernels.cpp,point_kernels.cpp,rigid_kernels.cpp,rigid_motion_kernels.cpp,step.cpp
    quoin_analysis:5
    quoin_modes:3:modes.cpp
    quoin_results:10:report.cpp,vtk.cpp,vtk_file.cpp
    quoin_validate:4
    quoin_ensemble:7
    quoin_reproduce:11:cyclic_studies.cpp,parameter_studies.cpp,run_cache.cpp
    quoin:11:limit_command.cpp,modes_command.cpp,reproduce_command.cpp
    quoin_python:6
    cli_test:9
    verification_test:6:threads_test.cpp
    cyclic_joint_test:4:convergence_test.cpp
    law_test:4
    scene_test:8:generate_blocks_test.cpp,read_block_scene_test.cpp
    host_test:8:kernels_choice_test.cpp,ranks_test.cpp,surface_test.cpp
    records_test:6
    results_test:2
    frames_test:3:frames_test.cpp
    geometry_test:3:mesh_file_test.cpp
    random_test:3:correlation_test.cpp
    ensemble_test:3
    validate_test:4
    reproduce_test:2:whole_studies_test.cpp)
set(QUOIN_FILE_BY_FILE "" CACHE STRING "Targets that the quick build compiles file by file")
foreach(entry IN LISTS batches)
  string(REPLACE ":" ";" entry ${entry})
  list(GET entry 0 target)
  list(GET entry 1 batch)
  if(NOT TARGET ${target} OR target IN_LIST QUOIN_FILE_BY_FILE)
    continue()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${batch})
  list(LENGTH entry length)
  if(length GREATER 2)
    list(GET entry 2 alone)
    string(REPLACE "," ";" alone ${alone})
    get_target_property(folder ${target} SOURCE_DIR)
    list(TRANSFORM alone PREPEND ${folder}/)
    set_source_files_properties(${alone} TARGET_DIRECTORY ${target} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endforeach()

# target:headers beside those of every list. Kernels go without: their headers are compiled for each instruction set.
set(common <algorithm> <array> <chrono> <cmath> <cstring> <filesystem> <fstream> <functional> <map> <memory> <mutex>
    <optional> <set> <span> <sstream> <stdexcept> <string> <thread> <unordered_map> <variant> <vector> <fmt/format.h>)
set(precompiled
    quoin_model:${PROJECT_SOURCE_DIR}/host/model/world.h
    quoin_step:${PROJECT_SOURCE_DIR}/host/step/state.h
    quoin_results:<nlohmann/json.hpp>
    host_test:<gmock/gmock.h>,${PROJECT_SOURCE_DIR}/tests/host/support.h
    members_test:<gmock/gmock.h>,${PROJECT_SOURCE_DIR}/tests/members/scenes.h)
foreach(entry IN LISTS precompiled)
  string(REPLACE ":" ";" entry ${entry})
  list(GET entry 0 target)
  list(GET entry 1 headers)
  if(NOT TARGET ${target})
    continue()
  endif()
  string(REPLACE "," ";" headers "${headers}")
  target_precompile_headers(${target} PRIVATE ${common} ${headers})
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "kernels\\.cpp$")
  get_target_property(folder ${target} SOURCE_DIR)
  list(TRANSFORM sources PREPEND ${folder}/)
  if(sources)
    set_source_files_properties(${sources} TARGET_DIRECTORY ${target} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
  endif()
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)  # without it ccache keeps nothing
  if(target MATCHES "_test$")
    # At -O1 GCC 12 sees an overrun in std::string + "text" once <string> is precompiled.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds>)
  endif()
endforeach()
