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

  type, bind(c) :: quoin_property_info
    integer(c_int64_t) :: struct_size
    type(c_ptr) :: id, symbol, unit, description
    integer(c_int32_t) :: kind, flags
    real(c_double) :: default_value, lower, upper
    type(c_ptr) :: default_from, default_text
    integer(c_int64_t) :: choice_count
    type(c_ptr) :: choices
  end type

  type, bind(c) :: quoin_state_info
    integer(c_int64_t) :: struct_size
    type(c_ptr) :: id, unit, description
    integer(c_int32_t) :: role, kind, flags, reserved
    real(c_double) :: lower, upper
  end type

  type, bind(c) :: quoin_stiffness_bounds
    integer(c_int64_t) :: struct_size = 24
    real(c_double) :: normal = 0, shear = 0
  end type

  type, bind(c) :: quoin_property_value
    integer(c_int64_t) :: struct_size = 40
    type(c_ptr) :: id = c_null_ptr
    integer(c_int64_t) :: number_count = 0
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
    subroutine destroy_material_function(material) bind(c)
      import
      type(c_ptr), value :: material
    end subroutine
    function stiffness_bounds_function(material, bounds) bind(c) result(code)
      import
      type(c_ptr), value :: material
      type(quoin_stiffness_bounds), intent(inout) :: bounds
      integer(c_int32_t) :: code
    end function
  end interface

  interface
    function strlen(text) bind(c) result(length)
      import
      type(c_ptr), value :: text
      integer(c_size_t) :: length
    end function
    function dlerror() bind(c) result(text)
      import
      type(c_ptr) :: text
    end function
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

  function fortran_text(text) result(copy)  ! of a C string; empty for null
    type(c_ptr), intent(in) :: text
    character(:), allocatable :: copy
    character(kind=c_char), pointer :: characters(:)
    integer :: i
    copy = ""
    if (.not. c_associated(text)) return
    call c_f_pointer(text, characters, [strlen(text)])
    copy = repeat(" ", size(characters))
    do i = 1, size(characters)
      copy(i:i) = characters(i)
    end do
  end function

  function open_law(path, reason) result(law)  ! the first law of a library; null, and the reason, when refused
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: reason
    type(quoin_law), pointer :: law
    type(quoin_library), pointer :: library
    type(c_ptr), pointer :: laws(:)
    character(kind=c_char, len=1000), target :: message
    type(quoin_host_info) :: host
    type(quoin_text) :: text
    procedure(library_function), pointer :: entry
    type(c_ptr) :: handle, info
    type(c_funptr) :: address
    law => null()
    address = c_null_funptr
    handle = dlopen(path // c_null_char, 2)
    if (c_associated(handle)) address = dlsym(handle, "quoin_library_v1" // c_null_char)
    if (.not. c_associated(address)) then
      reason = fortran_text(dlerror())
      return
    end if
    call c_f_procpointer(address, entry)
    text%data = c_loc(message)
    text%capacity = len(message)
    info = entry(host, text)
    reason = path // ": " // message(1:min(int(text%length), len(message)))
    if (.not. c_associated(info)) return
    call c_f_pointer(info, library)
    if (library%abi_major /= 1) then
      reason = path // ": speaks another version of the contract than 1"
      return
    end if
    call c_f_pointer(library%laws, laws, [library%law_count])
    call c_f_pointer(laws(1), law)
  end function

end module
