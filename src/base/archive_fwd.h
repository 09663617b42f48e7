#pragma once

namespace cosiva {

/// archive.h, for the headers of classes that list their state in their source: the templates are compiled only there.
class Archive;

}  // namespace cosiva
