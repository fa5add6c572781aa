# -D MODEL= -D BLANK= -D XML= -D SOURCE=: fills the empty GUID of BLANK with a hash of the file and writes XML, and
# SOURCE, the file that tells the binary its mechanism and GUID.
file(READ ${BLANK} text)
string(UUID guid NAMESPACE 6ba7b812-9dad-11d1-80b4-00c04fd430c8 NAME "${text}" TYPE SHA1)
string(REPLACE "guid=\"\"" "guid=\"{${guid}}\"" text "${text}")
file(CONFIGURE OUTPUT ${XML} CONTENT "${text}" @ONLY)
file(CONFIGURE OUTPUT ${SOURCE} @ONLY CONTENT
"// Generated.
#include \"fmi/model.h\"

namespace sigmafmu {
namespace models {
Mechanism @MODEL@();
}
Mechanism make_mechanism() { return models::@MODEL@(); }
const char* const kGuid = \"{@guid@}\";
}  // namespace sigmafmu
")
