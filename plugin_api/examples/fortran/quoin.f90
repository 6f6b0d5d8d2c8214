! The contact-law ABI for Fortran: derived types and loading. 64-bit Linux.
module quoin
  use, intrinsic :: iso_c_binding
  implicit none

  type, bind(c) :: quoin_column          ! quoin_in, quoin_out, quoin_out_u32
    type(c_ptr) :: data = c_null_ptr
    integer(c_int64_t) :: stride = 0
  end type

  type, bind(c) :: quoin_text
    integer(c_int64_t) :: struct_size = 32
    type(c_ptr) :: data = c_null_ptr
    integer(c_int64_t) :: capacity = 0, length = 0
  end type

  type, bind(c) :: quoin_host_info
    integer(c_int64_t) :: struct_size = 32
    integer(c_int32_t) :: abi_major = 1, abi_minor = 0
    type(c_ptr) :: name = c_null_ptr, version = c_null_ptr
  end type

  type, bind(c) :: quoin_library
    integer(c_int64_t) :: struct_size
    integer(c_int32_t) :: abi_major, abi_minor
    type(c_ptr) :: name, version
    integer(c_int64_t) :: law_count
    type(c_ptr) :: laws
    type(c_funptr) :: extension
  end type

  type, bind(c) :: quoin_law
    integer(c_int64_t) :: struct_size
    type(c_ptr) :: id, name, version, citation, description
    integer(c_int64_t) :: capabilities
    type(c_ptr) :: convention
    integer(c_int64_t) :: property_count
    type(c_ptr) :: properties
    integer(c_int64_t) :: state_count
    type(c_ptr) :: states
    integer(c_int64_t) :: initial_state_count
    type(c_ptr) :: initial_states
    integer(c_int64_t) :: state_schema
    type(c_funptr) :: create_material, destroy_material, material_number, initial_state, stiffness_bounds, evaluate, &
                      migrate_state
  end type

  type, bind(c) :: quoin_property_value
    integer(c_int64_t) :: struct_size = 40
    type(c_ptr) :: id = c_null_ptr
    integer(c_int64_t) :: number_count = 1
    type(c_ptr) :: numbers = c_null_ptr, text = c_null_ptr
  end type

  type, bind(c) :: quoin_batch
    integer(c_int64_t) :: struct_size = 0, count = 0
    type(quoin_column) :: normal_jump, slip_increment(2), traction_old(3)
    type(c_ptr) :: state_old = c_null_ptr
    type(quoin_column) :: traction_new(3)
    type(c_ptr) :: state_new = c_null_ptr
    integer(c_int64_t) :: property_column_count = 0
    type(c_ptr) :: property_columns = c_null_ptr
    type(quoin_column) :: energy_stored, dissipated(4), tangent(9), flags, status
    integer(c_int64_t) :: clamped_count = 0, failed_count = 0
    integer(c_int32_t) :: worst_status = 0, any_yielding = 0
  end type

  abstract interface
    function library_function(host, text) bind(c) result(library)
      import
      type(quoin_host_info), intent(in) :: host
      type(quoin_text), intent(inout) :: text
      type(c_ptr) :: library
    end function
    function create_material_function(law, value_count, values, material, text) bind(c) result(code)
      import
      type(quoin_law), intent(in) :: law
      integer(c_int64_t), value :: value_count
      type(c_ptr), intent(in) :: values(*)
      type(c_ptr), intent(out) :: material
      type(quoin_text), intent(inout) :: text
      integer(c_int32_t) :: code
    end function
    function evaluate_function(material, batch) bind(c) result(code)
      import
      type(c_ptr), value :: material
      type(quoin_batch), intent(inout) :: batch
      integer(c_int32_t) :: code
    end function
    function initial_state_function(material, id, values) bind(c) result(code)
      import
      type(c_ptr), value :: material, id
      real(c_double), intent(out) :: values(*)
      integer(c_int32_t) :: code
    end function
  end interface

  interface
    function dlopen(path, mode) bind(c) result(handle)
      import
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
      type(c_ptr) :: handle
    end function
    function dlsym(handle, name) bind(c) result(address)
      import
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: name(*)
      type(c_funptr) :: address
    end function
  end interface

contains

  function open_law(path) result(law)  ! the first law of a library; null when refused
    character(*), intent(in) :: path
    type(quoin_law), pointer :: law
    type(quoin_library), pointer :: library
    type(c_ptr), pointer :: laws(:)
    type(quoin_host_info) :: host
    type(quoin_text) :: text
    procedure(library_function), pointer :: entry
    type(c_ptr) :: handle, info
    type(c_funptr) :: address
    law => null()
    handle = dlopen(path // c_null_char, 2)
    if (.not. c_associated(handle)) return
    address = dlsym(handle, "quoin_library_v1" // c_null_char)
    if (.not. c_associated(address)) return
    call c_f_procpointer(address, entry)
    info = entry(host, text)
    if (.not. c_associated(info)) return
    call c_f_pointer(info, library)
    if (library%abi_major /= 1) return
    call c_f_pointer(library%laws, laws, [library%law_count])
    call c_f_pointer(laws(1), law)
  end function

end module
