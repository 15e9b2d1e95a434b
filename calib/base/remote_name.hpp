#pragma once

#include <string>
#include <string_view>

namespace ceilmap {

/// Whether a name is that of a file on a server: a URL (http://, https://), or one of the names
/// that GDAL gives to such files (/vsicurl/URL, /vsis3/BUCKET/KEY).
bool IsRemoteName(std::string_view name);

/// A name, an argument or a message without what must not be shown or stored: the password of a URL
/// (`scheme://user:password@host`), the query of a web address (which may be a signature), and the
/// value behind `password=` (in the connection string of a database). Each becomes `***`.
std::string WithoutSecrets(std::string_view text);

}  // namespace ceilmap
