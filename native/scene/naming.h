// SPDX-License-Identifier: GPL-3.0-or-later
// Error messages that say which thing of the scene is at fault.
#pragma once

#include <new>
#include <stdexcept>
#include <string>

namespace nephele {

/// Runs `what`, putting the name of the thing at fault before the message of whatever it throws:
/// std::invalid_argument, since it is the input that is at fault. Running out of memory is not, and passes.
template <class F>
auto naming(const std::string& name, F&& what) {
    try {
        return what();
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        throw std::invalid_argument(name + ": " + e.what());
    }
}

}  // namespace nephele
