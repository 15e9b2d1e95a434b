#pragma once

#include <string>

#include "mapping/store/postgis_database.hpp"

/// Tables, views and reference systems of the schema `ceilmap` (postgis.hpp). Internal.
namespace ceilmap::store {

/// Makes what is missing. A user who may only write rows needs no right to make tables.
/// @throws InputError when the database has no PostGIS.
void MakePostgisTables(PostgisDatabase& database);

/// The number by which the database knows a coordinate reference system: that of its EPSG code, or
/// of an entry in spatial_ref_sys, which is made when it is missing and the user may. 0: it has
/// none.
/// @param wkt  WKT 2; empty: a local system.
int SridOf(PostgisDatabase& database, const std::string& wkt);

/// Views KEYFRAMES_SRID, ... of the rows with this reference system, as GIS programs need them; not
/// made where the user may not.
void MakePostgisViews(PostgisDatabase& database, int srid);

}  // namespace ceilmap::store
