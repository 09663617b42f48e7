#include "cosiva/base/archive.h"

namespace cosiva {

void Archive::list_members(std::initializer_list<const char*> types) {
  std::string list{"("};
  for (const char* type : types) list.append(type).push_back(' ');
  list.push_back(')');
  if (members_.find(list) == std::string::npos) members_.append(list);
}

}  // namespace cosiva
