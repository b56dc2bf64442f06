# SPDX-License-Identifier: GPL-3.0-or-later
#
# nephele_generate_tables(out_dir): settings, passes and opcodes are declared once, in Python; this turns them
# into C++ headers in out_dir, again whenever a declaration changes. Link the interface target nephele_tables to
# include <settings_table.h>, <passes_table.h> and <opcodes_table.h>.

function(nephele_generate_tables out_dir)
    set(generator "${PROJECT_SOURCE_DIR}/tools/generate_tables.py")
    set(headers
        "${out_dir}/settings_table.h"
        "${out_dir}/passes_table.h"
        "${out_dir}/opcodes_table.h")
    add_custom_command(
        OUTPUT ${headers}
        COMMAND "${CMAKE_COMMAND}" -E make_directory "${out_dir}"
        COMMAND "${Python_EXECUTABLE}" "${generator}" --output "${out_dir}"
        DEPENDS
            "${generator}"
            "${PROJECT_SOURCE_DIR}/addon/parameters.py"
            "${PROJECT_SOURCE_DIR}/addon/passes.py"
            "${PROJECT_SOURCE_DIR}/addon/opcodes.py"
        WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}"
        COMMENT "Generating settings_table.h, passes_table.h, opcodes_table.h"
        VERBATIM)
    add_custom_target(nephele_tables_files DEPENDS ${headers})
    add_library(nephele_tables INTERFACE)
    target_include_directories(nephele_tables INTERFACE "${out_dir}")
    add_dependencies(nephele_tables nephele_tables_files)
endfunction()
