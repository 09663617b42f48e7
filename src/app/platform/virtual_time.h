#pragma once

#include "cosiva/app/platform/up_arguments.h"

namespace cosiva::app {

/// `cosiva up --virtual-time`: the whole platform in this process, as fast as possible or with a page. Gives the exit
/// status as run_up does.
int run_virtual_time(const UpArguments& arguments);

}  // namespace cosiva::app
