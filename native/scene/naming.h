// SPDX-License-Identifier: GPL-3.0-or-later
// Error messages that say which thing of the scene is at fault.
#pragma once

#include <stdexcept>
#include <string>

namespace nephele {

/// Runs `what`, putting the name of the thing at fault before the message of whatever it throws.
template <class F>
auto naming(const std::string& name, F&& what) {
    try {
        return what();
    } catch (const std::exception& e) {
        throw std::runtime_error(name + ": " + e.what());
    }
}

}  // namespace nephele
