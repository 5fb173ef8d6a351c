!> Checkpoint and restart in one's own program: a chain of three rods stops half-way, is written to a file, and goes on in another
!! simulation, bit for bit as if there had been no stop.
module stopping
   use taut
   implicit none (type, external)

   !> Asks for a pause after so many steps.
   type, extends(pause_t) :: after_t
      integer :: steps = 100
   contains
      procedure :: wanted
   end type after_t

contains

   logical function wanted(self)                        ! asked before every step
      class(after_t), intent(inout) :: self
      self%steps = self%steps - 1
      wanted = self%steps < 0
   end function wanted

end module stopping

program checkpoint
   use taut
   use stopping
   implicit none (type, external)
   character(*), parameter :: path = 'checkpoint_of_example.taut'
   type(chain_model_t) :: chain
   type(state_t) :: at
   type(simulation_t) :: whole, first, second
   type(after_t) :: pause
   type(archive_t) :: archive, back
   type(error_t), allocatable :: error
   integer :: unit

   call new_chain_model(chain, 3, 1.0_wp, 1.0_wp, 9.81_wp, error)
   call chain%start(0.0_wp, at)
   call whole%init(chain, error)
   call whole%run(at, 3.0_wp, error)

   call first%init(chain, error)
   call first%run(at, 3.0_wp, error, pause=pause)
   print '(2a, f8.4, a)', status_name(first%result%status), ' at', first%result%t, ' s'
   call first%serialize(archive)                        ! into the archive
   open (newunit=unit, file=path, access='stream', form='unformatted', status='replace')
   write (unit) archive%length, archive%bytes(:archive%length)
   close (unit)

   open (newunit=unit, file=path, access='stream', form='unformatted', status='old')
   read (unit) back%length
   allocate (back%bytes(back%length))
   read (unit) back%bytes
   close (unit, status='delete')
   call back%rewind()
   call second%init(chain, error)                       ! as the first one was
   call second%serialize(back)                       ! out of the archive
   call second%resume()
   if (allocated(error) .or. allocated(back%error)) error stop 'something went wrong'
   print '(2a, f8.4, a, es9.1)', status_name(second%result%status), ' at', second%result%t, &
      ' s, difference:', maxval(abs(second%at%x - whole%at%x))
end program checkpoint
